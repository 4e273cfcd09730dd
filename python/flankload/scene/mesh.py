"""The tables of bodies that come from files: a mesh, or a compliance computed before."""

from typing import Annotated, Literal

from msgspec import Meta

from flankload.scene.gear_tables import Geometry
from flankload.scene.table import (
    USUAL_SIZE,
    BodyTable,
    Length,
    PitchErrors,
    PoissonRatio,
    Rigid,
    Teeth,
    Text,
    YoungModulus,
    about,
)


class Profile(Geometry, frozen=True, kw_only=True):
    """The exact profile of a body that comes as a mesh: the geometry keys of a gear."""

    kind: Annotated[Literal["gear"], about("", "kind of the profile")] = "gear"
    teeth: Annotated[
        Teeth | None,
        about("-", "number of teeth; absent = that of the mesh, else equal to it"),
    ] = None


class MeshBody(BodyTable, frozen=True, kw_only=True, tag="mesh"):
    """A body as a mesh file: one sector with its cut faces, or the whole body with many flanks."""

    file: Annotated[Text, about("", "mesh file; relative to the folder of the scene file")]
    teeth: Annotated[
        Teeth | None,
        about(
            "-",
            "number of equal sectors of the body; a whole body: absent = as many as flank_sets",
        ),
    ] = None
    flank_set: Annotated[Text, about("", "set of the working flank's edges or nodes")] = "FLANK"
    flank_sets: Annotated[
        Annotated[tuple[Text, ...], Meta(min_length=1)] | None,
        about(
            "",
            "a whole body: sets of its working flanks, that of pair 0 first; no flank_set and no "
            "cut_sets then",
        ),
    ] = None
    fixed_set: Annotated[Text, about("", "set that is held (the bore)")] = "BORE"
    cut_sets: Annotated[tuple[Text, Text], about("", "sets of the sector's two cut faces")] = (
        "CUT_LEFT",
        "CUT_RIGHT",
    )
    reference_radius_mm: Annotated[
        Length | None,
        about(
            "mm",
            "radius that turns rotation into transmission error; needed without profile, else the "
            "base radius",
            usual=USUAL_SIZE,
        ),
    ] = None
    profile: Annotated[
        Profile | None,
        about("", "the exact profile, where it is known; else the curve goes through the nodes"),
    ] = None
    one_material: Annotated[
        bool, about("", "true: groups of elements in the file are one material all the same")
    ] = False
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()

    @property
    def number_of_teeth(self) -> int:
        """Teeth as given, or as many as there are flanks."""
        return self.teeth or len(self.flank_sets or ())


class ComplianceBody(BodyTable, frozen=True, kw_only=True, tag="compliance"):
    """A body whose flank and compliance come from a file, computed before, here or elsewhere."""

    file: Annotated[
        Text,
        about("", "compliance file (.npz, .csv); relative to the folder of the scene file"),
    ]
    rigid: Rigid = False
    pitch_errors_um: Annotated[PitchErrors, about("um", "absent = those of the file")] = ()
