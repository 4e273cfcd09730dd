"""Tip and root reliefs of involute profiles: their keys and rules."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.refusal import refuse, refuse_absent
from flankload.scene.table import (
    PER_MODULE,
    USUAL_MODIFICATION,
    USUAL_SIZE,
    Length,
    Relief,
    ReliefShape,
    about,
)
from flankload.scene.thickness import ThicknessKeys

RollAngle = Annotated[float, Meta(gt=0, le=1000)]
#: Length of a relief by the points of the path of contact where the number of pairs changes.
ReliefLength = Literal["long", "short"]
#: Keys of the start of a relief, one of which it requires: "{}" is "tip" or "root".
STARTS = (
    "{}_relief_start_diameter_mm",
    "{}_relief_start_roll_angle_deg",
    "{}_relief_length_mm",
    "{}_relief_length",
)
_DOUBLE = "double_linear"


class ReliefKeys(ThicknessKeys, frozen=True, kw_only=True):
    """Keys of the tip relief and the root relief."""

    instead_of: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "tip_relief_start_diameter_mm": tuple(name.format("tip") for name in STARTS[1:]),
        "root_relief_start_diameter_mm": tuple(
            name.format("root") for name in STARTS[1:] if "length_mm" not in name
        ),
    }

    tip_relief_um: Annotated[
        Relief | None,
        about(
            "tip relief at the tip circle, normal to the involute",
            "um",
            usual=USUAL_MODIFICATION,
            per=PER_MODULE,
        ),
    ] = None
    tip_relief_start_diameter_mm: Annotated[
        Length | None, about("diameter at which the tip relief begins", "mm", usual=USUAL_SIZE)
    ] = None
    tip_relief_start_roll_angle_deg: Annotated[
        RollAngle | None,
        about("roll angle at which the tip relief begins, in place of its diameter", "deg"),
    ] = None
    tip_relief_length_mm: Annotated[
        Length | None,
        about(
            "length of the tip relief along the path of contact, from the tip circle (L_Ca), in "
            "place of the diameter at its start",
            "mm",
            usual=(0.01, 200.0),
        ),
    ] = None
    tip_relief_length: Annotated[
        ReliefLength | None,
        about(
            "in place of the diameter at the start of the tip relief: 'long' = from the end of "
            "single contact (point D of body 1, B of body 2), 'short' = half of that length"
        ),
    ] = None
    tip_relief_shape: Annotated[
        Literal[ReliefShape, "double_linear"],
        about(
            "shape of the tip relief over the roll angle: 'linear', as on drawings, begins with a "
            "kink, which acts as a sharp corner; 'parabolic' begins without a kink; "
            "'double_linear' has two straight parts that meet at tip_relief_knee_diameter_mm"
        ),
    ] = "linear"
    tip_relief_knee_um: Annotated[
        Relief | None,
        about(
            "tip relief at tip_relief_knee_diameter_mm, with tip_relief_shape = 'double_linear'",
            "um",
            usual=USUAL_MODIFICATION,
            per=PER_MODULE,
        ),
    ] = None
    tip_relief_knee_diameter_mm: Annotated[
        Length | None,
        about("diameter at which both parts of the tip relief meet", "mm", usual=USUAL_SIZE),
    ] = None
    root_relief_um: Annotated[
        Relief | None,
        about(
            "root relief at the form circle, normal to the involute",
            "um",
            usual=USUAL_MODIFICATION,
            per=PER_MODULE,
        ),
    ] = None
    root_relief_start_diameter_mm: Annotated[
        Length | None, about("diameter at which the root relief begins", "mm", usual=USUAL_SIZE)
    ] = None
    root_relief_start_roll_angle_deg: Annotated[
        RollAngle | None,
        about("roll angle at which the root relief begins, in place of its diameter", "deg"),
    ] = None
    root_relief_length: Annotated[
        ReliefLength | None,
        about(
            "in place of the diameter at the start of the root relief: 'long' = up to the start "
            "of single contact (point B of body 1, D of body 2), 'short' = half of that length"
        ),
    ] = None
    root_relief_shape: Annotated[
        ReliefShape,
        about("shape of the root relief over the roll angle, as tip_relief_shape"),
    ] = "linear"


def check_reliefs(body: ReliefKeys, given: Mapping[str, Any], key: str) -> None:
    """Check that reliefs have a start, and a double-linear tip relief a knee."""
    double = body.tip_relief_shape == _DOUBLE
    for name in ("tip_relief_knee_um", "tip_relief_knee_diameter_mm"):
        value = getattr(body, name)
        if double and body.tip_relief_um and value is None:
            refuse(f"{key}.{name}", f"a number, since {key}.tip_relief_shape is '{_DOUBLE}'", None)
        if not double and value is not None:
            refuse(f"{key}.{name}", f"nothing without {key}.tip_relief_shape = '{_DOUBLE}'", value)
    for end in ("tip", "root"):
        amount, start = f"{end}_relief_um", f"{end}_relief_start_diameter_mm"
        starts = (start, *body.instead_of[start])
        if getattr(body, amount) is None:
            for name in (*starts, f"{end}_relief_shape"):
                if name in given:
                    refuse_absent(key, amount, "a number >= 0", name)
        # a relief of 0 begins nowhere
        elif getattr(body, amount) and all(getattr(body, name) is None for name in starts):
            expected = f"a number > 0 (or {', '.join(starts[1:])})"
            refuse_absent(key, start, expected, amount)
