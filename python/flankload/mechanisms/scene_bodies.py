"""Bodies of a scene by the names of their tables, not yet paired, for every kind of drive."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.bodies import Body, build_body
from flankload.bodies.imported.compliance import ModalCompliance
from flankload.errors import SceneError
from flankload.mechanisms.registry import require_flanks
from flankload.mechanisms.reuse import made_once
from flankload.pairing.node_spacing import spacing_for_loads
from flankload.scene.discretization import DEFAULT, Discretization, elements_for_modes
from flankload.scene.effects import effects_of
from flankload.scene.unmodified import unmodified

if TYPE_CHECKING:
    from flankload.mechanisms.reuse import Parts
    from flankload.scene import BodySpec, Scene

#: Tables of the bodies of a pair.
PAIR = ("body_1", "body_2")


def bodies_of(
    scene: Scene,
    discretization: Discretization,
    names: tuple[str, ...] = PAIR,
    *,
    parts: Parts | None = None,
    modified_elements: bool = False,
) -> tuple[Body, ...]:
    """Bodies of a scene, not yet paired.

    Parameters
    ----------
    names : tuple of str
        Tables of the bodies in the scene.
    parts : Parts, optional
        Parts of earlier runs.
    modified_elements : bool
        Whether elements follow the modified flanks, for another program.

    Raises
    ------
    SceneError
        If a body cannot be made; names file, key, expected and found.
    """
    require_flanks(scene)
    made = partial(_body, scene, discretization, parts, modified_elements=modified_elements)
    element_mm = scene.accuracy.flank_element_mm
    try:
        if effects_of(scene).nodal_near_field:
            # from the scene, or from the contact width
            nodes_mm = element_mm or node_spacing_of(scene, parts)
            bodies = {name: made(name, nodes_mm=nodes_mm) for name in names}
            for name, body in bodies.items():
                _check_nodes(body, name)
            return tuple(bodies.values())
        bodies = {name: made(name, element_mm=element_mm) for name in names}
        if element_mm is None and (scene.accuracy.modes or 0) > DEFAULT.modes:
            for name, body in bodies.items():
                nodes_mm = _nodes_of_modes(body, scene, name)
                if nodes_mm is not None:
                    bodies[name] = made(name, nodes_mm=nodes_mm)
        return tuple(bodies.values())
    except SceneError as error:
        raise with_file_of(scene, error) from None


def node_spacing_of(scene: Scene, parts: Parts | None = None) -> float | None:
    """Distance of nodes with forces by the contact width, mm; None without elements."""
    one, two = (_body(scene, DEFAULT, parts, name) for name in PAIR)
    return spacing_for_loads((one, two), scene.torques_Nmm, scene.pair.face_width_mm)


def with_file_of(scene: Scene, error: SceneError) -> SceneError:
    """Add the scene's file to an error that names no file."""
    if error.file is not None or scene.file is None:
        return error
    return error.with_file(scene.file)


def _check_nodes(body: Body, key: str) -> None:
    """Refuse nodal forces for a body with imported pressure modes: its file has no nodal tables."""
    if isinstance(body.imported, ModalCompliance):
        raise SceneError(
            key="effects.near_field",
            expected=f"'analytic', since {key}.file holds pressure modes: nodes that carry forces "
            f"come from elements, or from a matrix between nodes in {key}.file",
            found="'nodes'",
        )


def _nodes_of_modes(body: Body, scene: Scene, name: str) -> float | None:
    """Spacing of flank nodes for the given number of modes; None if the mesh is fine enough."""
    assert scene.accuracy.modes is not None
    wanted = elements_for_modes(scene.accuracy.modes)
    parametric = hasattr(getattr(scene, name), "module_mm")
    if not parametric or body.mesh is None or body.mesh.flank_elements >= wanted:
        return None
    low, high = body.unmodified.mode_range_mm
    return (high - low) / wanted


def _body(
    scene: Scene,
    discretization: Discretization,
    parts: Parts | None,
    name: str,
    *,
    element_mm: float | None = None,
    nodes_mm: float | None = None,
    modified_elements: bool = False,
) -> Body:
    """A body with elements of a length on its flank, or nodes at a distance."""
    spec: BodySpec = getattr(scene, name)

    def built(spec: BodySpec) -> Body:
        call = partial(
            _built,
            _stamps(scene, name),
            spec,
            name,
            folder=scene.folder,
            flank_element_mm=element_mm,
            flank_element_parts=discretization.flank_element_parts,
            flank_nodes_mm=nodes_mm,
            pair_width_mm=scene.pair.face_width_mm if effects_of(scene).three_dimensions else None,
        )
        return made_once(call, parts)

    if spec.from_file:  # which has the elements
        discretization, element_mm, nodes_mm = DEFAULT, None, None
    errors_um = () if spec.from_file else spec.pitch_errors_um
    if errors_um:  # they only shift the teeth, so bodies with other errors share the rest
        spec = structs.replace(spec, pitch_errors_um=())
    plain = unmodified(spec)
    if plain == spec or spec.rigid or spec.from_file or modified_elements:
        own = built(spec)
    else:  # a rigid body is made without a mesh
        own, elements = built(structs.replace(spec, rigid=True)), built(plain)
        own = replace(own, rigid=False, mesh=elements.mesh, elements=elements)
    return replace(own, pitch_errors_um=tuple(errors_um)) if errors_um else own


def _built(stamps: tuple[tuple[int, int], ...], spec: BodySpec, key: str, **keys: Any) -> Body:
    """A body from its keys and from files with these stamps."""
    return build_body(spec, key, **keys)


def _stamps(scene: Scene, body: str) -> tuple[tuple[int, int], ...]:
    """Time of change and size of the files of a body, as far as they exist."""
    stamps = []
    for name, path in scene.files.items():
        if name.startswith(f"{body}."):
            with suppress(OSError, ValueError):  # reading the file raises the error
                stat = path.stat()
                stamps.append((stat.st_mtime_ns, stat.st_size))
    return tuple(stamps)
