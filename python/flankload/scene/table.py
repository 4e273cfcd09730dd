"""Common parts of all tables of a scene file: number types, key metadata, keys of bodies."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from msgspec import UNSET, Meta, Struct, StructMeta, structs

#: Tables of bodies, in the order of a file; a scene has some of them.
BODIES = ("body_1", "planet", "body_3", "body_2")
#: Tables of drives with several gear meshes.
SEVERAL_MESHES = ("stage", "train")
#: Range of lengths, mm; far wider than that of real pairs. Beyond it, numbers overflow.
SMALLEST_LENGTH, LARGEST_LENGTH = 1e-3, 1e5
Length = Annotated[float, Meta(ge=SMALLEST_LENGTH, le=LARGEST_LENGTH)]
#: Largest relief, crowning or pitch error, um: a metre, more than any flank.
LARGEST_DEVIATION = 1e6
Relief = Annotated[float, Meta(ge=0, le=LARGEST_DEVIATION)]
#: Shapes of tip, root and end reliefs.
ReliefShape = Literal["linear", "parabolic"]
#: Exponent n of each shape; both parts of a double-linear relief are linear. A relief removes
#: amount x^n, with x from 0 at its start to 1 at its end. With n = 1 it begins with a kink.
RELIEF_EXPONENTS = {"linear": 1, "parabolic": 2, "double_linear": 1}
Deviation = Annotated[float, Meta(ge=-LARGEST_DEVIATION, le=LARGEST_DEVIATION)]
#: N m and N; more than any machine transmits.
Torque = Annotated[float, Meta(ge=0, le=1e12)]
Force = Annotated[float, Meta(ge=0, le=1e9)]
Text = Annotated[str, Meta(min_length=1)]
# deg; beyond thousands of turns, rounding errors exceed a tooth pitch
Angle = Annotated[float, Meta(ge=-1e7, le=1e7)]
Angles = Annotated[tuple[Angle, ...], Meta(min_length=1)]
Torques = Annotated[tuple[Torque, ...], Meta(min_length=1)]
Shift = Annotated[float, Meta(ge=-5, le=5)]


#: Default of a required key that can follow from a name (module `catalogue`). Tables made in Python
#: may omit it; the reader refuses scenes without it.
BY_NAME: Any = UNSET
#: Default of a required key that can follow from others of its table (`Table.instead_of`) or of
#: other tables (`Table.given_by_others`).
BY_OTHERS: Any = UNSET


def about(
    meaning: str,
    unit: str = "",
    *,
    usual: tuple[float, float] | None = None,
    per: tuple[str, float] | None = None,
) -> Meta:
    """Meaning and unit of a key ("-" for a pure number, "" for words), and its usual range.

    The program queries values outside the usual range (module `usual`). It includes every sensible
    design, but not a common value in a unit that is wrong by a factor of 1000. `per`: a length of
    the body in mm, and the largest usual value per mm of it.
    """
    more: dict[str, object] = {"unit": unit} if unit else {}
    if usual is not None:
        more["usual"] = list(usual)
    if per is not None:
        more["usual_per"] = list(per)
    return Meta(description=meaning, extra_json_schema=more or None)


#: Usual diameters, distances and widths, mm; from watches to rolling mills.
USUAL_SIZE = (0.2, 1e4)
#: Usual roundings and chamfers, mm.
USUAL_ROUNDING = (2e-3, 50.0)
#: Usual modifications of a flank, um.
USUAL_MODIFICATION = (0.3, 2000.0)
#: Largest usual modification of a profile, um per mm of the module: twice the tip relief that
#: compensates the deflection of teeth under the highest loads (0.02 of the module).
PER_MODULE = ("module_mm", 40.0)
#: Largest usual modification of a lead, um per mm of the face width, and largest misalignment.
LARGEST_TILT = 5.0
PER_WIDTH = ("face_width_mm", LARGEST_TILT)
#: Usual range of the largest pitch error, um.
USUAL_ERRORS = (0.1, 2000.0)

# Keys of several kinds of body.
#: Largest number of teeth; a matrix per tooth fits in memory.
MOST_TEETH = 10000
Teeth = Annotated[int, Meta(ge=3, le=MOST_TEETH)]
SMALLEST_MODULUS, LARGEST_MODULUS = 1e-3, 1e9
Modulus = Annotated[float, Meta(ge=SMALLEST_MODULUS, le=LARGEST_MODULUS)]
YoungModulus = Annotated[
    Modulus,
    # from PTFE to carbides
    about("Young's modulus", "MPa", usual=(400.0, 1e6)),
]
PoissonRatio = Annotated[float, Meta(ge=0, lt=0.5), about("Poisson's ratio", "-")]
Rigid = Annotated[bool, about("true: the body is rigid and has no finite elements")]
PitchErrors = Annotated[
    tuple[Deviation, ...],
    about(
        "one deviation per tooth along the base tangent, positive = excess material, early "
        "contact; in the order in which the teeth come into contact, from the tooth of pair 0",
        "um",
        usual=USUAL_ERRORS,
    ),
]


class _TableType(StructMeta):
    """Type of tables; wrong keyword arguments get an error that names all of them."""

    if not TYPE_CHECKING:  # the arguments are those of the class

        def __call__(self, *args: Any, **keys: Any) -> Any:
            try:
                return super().__call__(*args, **keys)
            except TypeError as error:
                raise TypeError(f"{self.__name__}: {_wrong(self, args, keys) or error}") from None


def _wrong(form: Any, args: tuple[Any, ...], keys: Mapping[str, Any]) -> str:
    """Unknown keyword arguments of a table; without one, the missing keys."""
    known = form.__struct_fields__
    for name in keys:
        if name not in known:
            from difflib import get_close_matches

            near = get_close_matches(name, known, n=1, cutoff=0.6)
            meant = f"did you mean {near[0]}?" if near else ", ".join(known)
            return f"expected a known key ({meant}), found the unknown key {name!r}"
    fields = [field for field in structs.fields(form) if field.name not in keys]
    absent = [field.name for field in fields[len(args) :] if field.required]
    return f"expected {', '.join(absent)}, found nothing" if absent else ""


class Table(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, metaclass=_TableType):
    """Base class of all tables.

    Attributes
    ----------
    grouped : bool
        The keys have the order of module `groups`; others have that of their class.
    instead_of : mapping of str to tuple of str
        For a key that can follow from others (module `derived`): the keys that give it, of which
        a table has at most one, in place of the key itself.
    """

    grouped: ClassVar[bool] = False
    instead_of: ClassVar[Mapping[str, tuple[str, ...]]] = {}

    @classmethod
    def also_required(cls, given: Mapping[str, Any]) -> tuple[str, ...]:
        """Optional keys that are required in a table with the given keys."""
        return ()

    @classmethod
    def given_by_others(cls, given: Mapping[str, Any]) -> Mapping[str, tuple[str, ...]]:
        """Keys of tables inside that follow from other tables, with the missing keys of these.

        Without a missing one, the key itself is not required.
        """
        return {}


class BodyTable(Table, frozen=True, kw_only=True, tag_field="kind"):
    """Base class of the tables of all kinds of bodies.

    Attributes
    ----------
    partner : str or None
        The only kind of the other body, if there is a restriction.
    from_file : bool
        The elements or the compliance of the body are imported from a file.
    brings_compliance : bool
        The file contains the compliance of the body instead of elements.
    is_drive : bool
        The body belongs to a chain or belt drive.
    has_teeth : bool
        The body has teeth with involute-like flanks; cams and followers have none.
    conforms : bool
        The flanks of a pair of such bodies conform: they touch over a length.
    """

    grouped: ClassVar[bool] = True
    partner: ClassVar[str | None] = None
    from_file: ClassVar[bool] = False
    brings_compliance: ClassVar[bool] = False
    is_drive: ClassVar[bool] = False
    has_teeth: ClassVar[bool] = True
    conforms: ClassVar[bool] = False

    @property
    def kind(self) -> str:
        """Kind of the body, as in the scene file."""
        return str(self.__struct_config__.tag)

    @property
    def has_free_bore(self) -> bool:
        """Whether only the mean motion of the bore, or of the outside of a rim, is held."""
        return False

    @property
    def flank_keys(self) -> tuple[str, Table | None]:
        """Prefix of the keys of an involute flank ("", "profile.") and their table, if any."""
        return "", None

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Refuse contradicting keys of this table; the default has no rules.

        Parameters
        ----------
        given : mapping
            Keys that the scene sets.
        key : str
            "body_1" or "body_2".
        """


class Toothed:
    """Mixin of bodies with a key `teeth`."""

    __slots__ = ()

    if TYPE_CHECKING:
        teeth: int

    @property
    def number_of_teeth(self) -> int:
        """Number of teeth, or of grooves."""
        return self.teeth


class EvenBody(BodyTable, frozen=True, kw_only=True):
    """Base class of bodies that cannot have pitch errors."""

    @property
    def pitch_errors_um(self) -> tuple[float, ...]:
        """Empty: the body has no pitch errors."""
        return ()


def has_several_meshes(scene: Any) -> bool:
    """Whether a scene, or its file, has a table of a drive with several gear meshes."""
    return any(getattr(scene, name) is not None for name in SEVERAL_MESHES)
