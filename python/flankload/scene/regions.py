"""Keys of web and hub, which are not as wide as the teeth, and their rules."""

from collections.abc import Iterator
from itertools import dropwhile
from typing import TYPE_CHECKING, Annotated, ClassVar

from msgspec import Meta

from flankload.base.rounding import TIE
from flankload.scene.refusal import refuse, refuse_absent, shown
from flankload.scene.table import LARGEST_LENGTH, USUAL_SIZE, Length, Text, about

if TYPE_CHECKING:
    from collections.abc import Sequence

    Extent = tuple[float, float]

#: Usual widths and offsets, mm.
USUAL_WIDTH, USUAL_OFFSET = (0.05, 5000.0), (1e-3, 5000.0)
Offset = Annotated[float, Meta(ge=-LARGEST_LENGTH, le=LARGEST_LENGTH)]

WebWidth = Annotated[
    Length | None,
    about("width of the web, at most the face width; absent = no web", "mm", usual=USUAL_WIDTH),
]
RingWebWidth = Annotated[
    Length | None,
    about(
        "width of the web between rim and outside, over which the outside is held; absent = no web",
        "mm",
        usual=USUAL_WIDTH,
    ),
]
WebOuterDiameter = Annotated[
    Length | None,
    about("diameter at which the web ends and the rim begins", "mm", usual=USUAL_SIZE),
]
WebInnerDiameter = Annotated[
    Length | None,
    about("diameter at which the rim ends and the web begins", "mm", usual=USUAL_SIZE),
]
RimThickness = Annotated[
    Length | None,
    about(
        "thickness of the rim from the root circle to the web (s_R of ISO 6336); replaces the "
        "diameter of the web",
        "mm",
        usual=USUAL_WIDTH,
    ),
]
WebOffset = Annotated[
    Offset,
    about(
        "axial position of the middle of the web from the middle of the face width",
        "mm",
        usual=USUAL_OFFSET,
    ),
]
HubDiameter = Annotated[Length | None, about("outer diameter of the hub", "mm", usual=USUAL_SIZE)]
HubWidth = Annotated[
    Length | None,
    about(
        "width of the hub, over which the bore is held; absent = no hub", "mm", usual=USUAL_WIDTH
    ),
]
HubOffset = Annotated[
    Offset,
    about(
        "axial position of the middle of the hub from the middle of the face width",
        "mm",
        usual=USUAL_OFFSET,
    ),
]
RegionSets = Annotated[
    Annotated[tuple[Text, ...], Meta(min_length=1)] | None,
    about(
        "sets of elements of regions that are not as wide as the teeth: webs, hubs; groups of the "
        "file then do not mean materials"
    ),
]
RegionWidths = Annotated[
    Annotated[tuple[Length, ...], Meta(min_length=1)] | None,
    about(
        "width of each of region_sets, about the middle of the face width", "mm", usual=USUAL_WIDTH
    ),
]


class WebKeys:
    """Mixin of bodies with keys of a web."""

    __slots__ = ()

    #: Key of the circle at which the web begins.
    web_circle: ClassVar[str]

    # defaults for rings, which lack these keys
    hub_diameter_mm: HubDiameter = None
    hub_width_mm: HubWidth = None
    hub_offset_mm: HubOffset = 0.0

    if TYPE_CHECKING:
        web_width_mm: WebWidth
        rim_thickness_mm: RimThickness
        web_offset_mm: WebOffset

    def _regions(self) -> Iterator[tuple[str, float, float]]:
        """Name, width and offset of web and hub, if present."""
        if self.web_width_mm is not None:
            yield "web", self.web_width_mm, self.web_offset_mm
        if self.hub_width_mm is not None:
            yield "hub", self.hub_width_mm, self.hub_offset_mm

    def check_regions(self, key: str) -> None:
        """Check that web and hub have a width and a diameter each."""
        given = {name: getattr(self, name) for name in (self.web_circle, "rim_thickness_mm")}
        if None not in given.values():
            expected = f"nothing beside {key}.{self.web_circle}"
            refuse(f"{key}.rim_thickness_mm", expected, self.rim_thickness_mm)
        places = [name for name, value in given.items() if value is not None]
        _check_both(key, self.web_circle, self.web_width_mm, places, self.web_offset_mm)
        places = ["hub_diameter_mm"] * (self.hub_diameter_mm is not None)
        _check_both(key, "hub_diameter_mm", self.hub_width_mm, places, self.hub_offset_mm)

    def regions_of(self, range_mm: "Extent") -> tuple[tuple[str, "Extent"], ...]:
        """Names and axial ranges of web and hub, except a web as wide as the teeth."""
        return tuple(dropwhile(lambda found: found[1] == range_mm, self._extents(range_mm)))

    def _extents(self, range_mm: "Extent") -> "Iterator[tuple[str, Extent]]":
        for name, width, offset in self._regions():
            yield name, _extent(range_mm, width, offset)

    def region_diameter_key(self, name: str) -> str:
        """The key of the circle at which web or hub begins."""
        if name == "hub":
            return "hub_diameter_mm"
        return self.web_circle if self.rim_thickness_mm is None else "rim_thickness_mm"


class RegionKeys(WebKeys):
    """Mixin of gears with keys of web and hub."""

    __slots__ = ()

    web_circle: ClassVar[str] = "web_outer_diameter_mm"

    if TYPE_CHECKING:
        bore_diameter_mm: float
        web_outer_diameter_mm: WebOuterDiameter

    def bore_of(self, range_mm: "Extent") -> "tuple[Extent, float]":
        """Axial range and diameter of the bore."""
        extents = [range_mm, *(own for _, own in self._extents(range_mm))]
        return extents[-1], self.bore_diameter_mm

    def check_extents(self, range_mm: "Extent", key: str) -> None:
        """Check that the web is within the face width, and the ends of the hub."""
        outside, around = "face width", range_mm
        for name, own in self._extents(range_mm):
            if not _is_within(own, around) and (name == "web" or not _is_within(around, own)):
                relation = "within" if name == "web" else "that contains or is within"
                expected = f"a {name} {relation} the {outside} ({_shown(around)})"
                refuse(f"{key}.{name}_width_mm", expected, f"{own[1] - own[0]:g} ({_shown(own)})")
            outside, around = name, own

    def region_radii(self, root_radius_mm: float, key: str) -> dict[str, float]:
        """Outer radii of web and hub.

        Raises
        ------
        SceneError
            If the circles overlap.
        """
        radii: dict[str, float] = {}
        bore, largest, circle = 0.5 * self.bore_diameter_mm, root_radius_mm, "the root diameter"
        for name, _, _ in self._regions():
            outer = self.region_diameter_key(name)
            given = getattr(self, outer)
            radius = 0.5 * given
            expected = f"more than {key}.bore_diameter_mm ({2 * bore:g}) and less than {circle} "
            expected += f"({2 * largest:.4f})"
            if outer == "rim_thickness_mm":
                radius = root_radius_mm - given
                expected = f"less than {root_radius_mm - bore:.4f}, since the rim ends outside "
                expected += f"{key}.bore_diameter_mm ({2 * bore:g})"
            if not bore < radius < largest:
                refuse(f"{key}.{outer}", expected, given)
            radii[name], largest, circle = radius, radius, "the outer diameter of the web"
        return radii


class RingWebKeys(WebKeys):
    """Mixin of rings with keys of a web between the rim and the outside."""

    __slots__ = ()

    web_circle: ClassVar[str] = "web_inner_diameter_mm"

    if TYPE_CHECKING:
        outer_diameter_mm: float
        web_inner_diameter_mm: WebInnerDiameter

    def check_extents(self, range_mm: "Extent", key: str) -> None:
        """Check the ends of the web."""
        for name, own in self._extents(range_mm):
            if not (_is_within(own, range_mm) or _is_within(range_mm, own)):
                expected = "a web that contains or is within the face width "
                expected += f"({_shown(range_mm)})"
                refuse(f"{key}.{name}_width_mm", expected, f"{own[1] - own[0]:g} ({_shown(own)})")

    def region_radii(self, root_radius_mm: float, key: str) -> dict[str, float]:
        """Inner radius of the web.

        Raises
        ------
        SceneError
            If the circles overlap.
        """
        if self.web_width_mm is None:
            return {}
        inner, outside = self.region_diameter_key("web"), 0.5 * self.outer_diameter_mm
        given = getattr(self, inner)
        radius = 0.5 * given
        expected = f"more than the root diameter ({2 * root_radius_mm:.4f}) and less than "
        expected += f"{key}.outer_diameter_mm ({2 * outside:g})"
        if inner == "rim_thickness_mm":
            radius = root_radius_mm + given
            expected = f"less than {outside - root_radius_mm:.4f}, since the rim ends within "
            expected += f"{key}.outer_diameter_mm ({2 * outside:g})"
        if not root_radius_mm < radius < outside:
            refuse(f"{key}.{inner}", expected, given)
        return {"web": radius}


def _check_both(
    key: str, circle: str, width: float | None, places: "Sequence[str]", offset: float
) -> None:
    """Check that a region has both a width and a diameter, or neither."""
    name = circle.partition("_")[0]
    if width is not None and not places:
        refuse_absent(key, circle, "a number > 0", f"{name}_width_mm")
    if width is None and (places or offset):
        refuse_absent(key, f"{name}_width_mm", "a number > 0", (*places, f"{name}_offset_mm")[0])


class MeshRegionKeys:
    """Mixin of meshes with named regions that are not as wide as the teeth."""

    __slots__ = ()

    if TYPE_CHECKING:
        region_sets: RegionSets
        region_widths_mm: RegionWidths

    def check_regions(self, key: str) -> None:
        """Check that each region has one width."""
        sets, widths = self.region_sets, self.region_widths_mm
        if widths is not None and sets is None:
            refuse_absent(key, "region_sets", "a list of names", "region_widths_mm")
        if sets is None:
            return
        if widths is None or len(widths) != len(sets):
            expected = f"a list of {len(sets)} numbers, one for each of {key}.region_sets"
            refuse(f"{key}.region_widths_mm", expected, widths)
        for k, name in enumerate(sets):
            if name in sets[:k]:
                refuse(f"{key}.region_sets[{k}]", "each set once", shown(name))

    def regions_of(self, range_mm: "Extent") -> tuple[tuple[str, "Extent"], ...]:
        """Names and axial ranges of the regions."""
        regions = zip(self.region_sets or (), self.region_widths_mm or (), strict=True)
        return tuple((name, _extent(range_mm, width, 0.0)) for name, width in regions)


def _extent(range_mm: "Extent", width_mm: float, offset_mm: float) -> "Extent":
    """Axial range of a region; exactly that of the teeth if equal up to rounding."""
    middle = 0.5 * (range_mm[0] + range_mm[1]) + offset_mm
    own = (middle - 0.5 * width_mm, middle + 0.5 * width_mm)
    same = _is_within(own, range_mm) and _is_within(range_mm, own)
    return range_mm if same else own


def _is_within(inner: "Extent", outer: "Extent") -> bool:
    rounding = TIE * (outer[1] - outer[0])
    return outer[0] - rounding <= inner[0] and inner[1] <= outer[1] + rounding


def _shown(extent: "Extent") -> str:
    return f"from {extent[0]:g} to {extent[1]:g} mm"
