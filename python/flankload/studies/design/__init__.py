"""Design studies: many runs of one scene with other values of some keys."""

from flankload.studies.design.design_study import DesignStudy
from flankload.studies.design.designs import Designs
from flankload.studies.design.solve_study import StudyFile, read_study, run_study, study

__all__ = ["DesignStudy", "Designs", "StudyFile", "read_study", "run_study", "study"]
