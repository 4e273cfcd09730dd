"""REXS, the exchange format of the FVA for gearboxes: a cylindrical or planetary stage as a scene.

`reading` makes a `Model` (components, attributes, relations) of an XML, JSON or ZIP file;
`attributes` is the table of the attributes that are read, each with its key of a scene;
`translation` makes the scene of one stage. Ids, units and allowed values are those of the attribute
database of REXS 1.5 and of its specification 1.4 to 1.7, with the older names of components of REXS
1.0 to 1.2.
"""

from flankload.exchange.rexs.model import Model
from flankload.exchange.rexs.reading import read_model
from flankload.exchange.rexs.stages import stage_rows
from flankload.exchange.rexs.translation import Choices, Translation, scene_of_stage

__all__ = ["Choices", "Model", "Translation", "read_model", "scene_of_stage", "stage_rows"]
