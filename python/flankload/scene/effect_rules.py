"""Effects that do not go together, or not with these bodies: one refusal at a time, both keys."""

from collections.abc import Mapping
from typing import Any

from flankload.errors import SceneError
from flankload.scene.belt_tables import Belt, Pulley
from flankload.scene.drive_tables import Chain, Sprocket
from flankload.scene.form import shown
from flankload.scene.tables import Cam, ComplianceBody, Follower, MeshBody, SceneFile

#: Strain up to which growth is linear, far beyond what any machine bears.
LARGEST_STRAIN = 0.02


#: Kinds of bodies whose coast flanks are not known, and why.
ONE_FLANK = {
    "mesh": "of whose teeth a file names one flank",
    "compliance": "of whose teeth a file names one flank",
    "cam": "which has one flank",
    "follower": "which has one flank",
    "sprocket": "whose pockets hold rollers",
    "chain": "which has no teeth",
}


def check_effects(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Refuse combinations of effects and bodies that have no meaning.

    Parameters
    ----------
    asked : SceneFile
    given : mapping
        The scene as it stands in the file.

    Raises
    ------
    SceneError
        Names the key, and in what it expects the other one.
    """
    effects = given.get("effects", {})
    _check_extent(asked, effects)
    _check_coupling(asked, effects)
    _check_growth(asked)
    _check_nodes(asked)
    _check_places(asked)
    _check_tip_contact(asked)
    _check_coast_flank(asked)


def check_coast_kinds(*kinds: str) -> None:
    """Check that both flanks of every tooth of body 1, of body 2 are known.

    Raises
    ------
    SceneError
    """
    for key, kind in zip(("body_1", "body_2"), kinds, strict=True):
        if kind in ONE_FLANK:
            raise SceneError(
                key="effects.coast_flank",
                expected=f"false with {key}.kind '{kind}', {ONE_FLANK[kind]}",
                found="true",
            )


def _refuse(key: str, expected: str, found: object) -> None:
    raise SceneError(key=key, expected=expected, found="nothing" if found is None else shown(found))


def _check_extent(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """A segment has an odd number of sectors, and the bodies have as many."""
    body, segment_teeth = asked.effects.body, asked.effects.segment_teeth
    if body != "segment" and segment_teeth is not None:
        _refuse(
            "effects.segment_teeth",
            "nothing, unless effects.body is 'segment'",
            segment_teeth,
        )
    if body == "whole":
        return
    if body == "segment" and (segment_teeth is None or segment_teeth % 2 == 0):
        _refuse(
            "effects.segment_teeth",
            "an odd number from 3, since effects.body is 'segment': as many teeth on both sides "
            "of the one in its middle",
            segment_teeth,
        )
    for key, spec in (("body_1", asked.body_1), ("body_2", asked.body_2)):
        if spec.rigid:
            continue
        if isinstance(spec, Sprocket | Chain | Pulley | Belt):
            continue  # these know no effects of elastic flanks at all
        if isinstance(spec, ComplianceBody):
            why = f"{key}.kind is 'compliance': its file says how much of the body it is"
        elif isinstance(spec, Cam | Follower):
            why = f"{key}.kind is '{spec.kind}', which has one flank"
        elif isinstance(spec, MeshBody) and spec.flank_sets is not None:
            why = f"{key}.flank_sets names the flanks of a whole body, not of one of its sectors"
        else:
            if segment_teeth is not None and segment_teeth > spec.number_of_teeth:
                _refuse(
                    "effects.segment_teeth",
                    f"at most {spec.number_of_teeth}, as many teeth as {key} has ({key}.teeth)",
                    segment_teeth,
                )
            continue
        _refuse("effects.body", f"'whole', since {why}", body)


def _check_coupling(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """One tooth alone has no neighbours to move, nor has a flank all around."""
    if asked.effects.body == "tooth" and given.get("tooth_coupling"):
        _refuse(
            "effects.tooth_coupling",
            "false or nothing, since effects.body is 'tooth': of a tooth by itself no other moves",
            True,
        )
    if not asked.effects.tooth_coupling and isinstance(asked.body_2, Cam):
        raise SceneError(
            key="effects.tooth_coupling",
            expected="true, since body_2.kind is 'cam': cam and follower have one flank each",
            found="false",
        )


def _check_growth(asked: SceneFile) -> None:
    """What stands beside a key that is absent; growth that wants elements where there are none."""
    effects = asked.effects
    for key, other in (
        ("thermal_expansion_per_K", "temperature_rise_K"),
        ("support_expansion_per_K", "temperature_rise_K"),
        ("density_kg_m3", "speed_rpm"),
    ):
        if getattr(effects, key) is not None and getattr(effects, other) is None:
            _refuse(
                f"effects.{key}",
                f"nothing, unless there is an effects.{other}",
                getattr(effects, key),
            )
    for expansion in ("thermal_expansion_per_K", "support_expansion_per_K"):
        for rise, per_K in zip(
            _of_both(effects.temperature_rise_K), _of_both(getattr(effects, expansion)), strict=True
        ):
            if abs(rise * per_K) > LARGEST_STRAIN:
                _refuse(
                    "effects.temperature_rise_K",
                    f"so few K that they stretch the bodies by {LARGEST_STRAIN:g} at most, with "
                    f"effects.{expansion} {per_K:g}",
                    rise,
                )
    if effects.speed_rpm and isinstance(asked.body_2, Cam):
        _refuse(
            "effects.speed_rpm",
            "nothing, since body_2.kind is 'cam': its follower, body_1, swings and does not turn",
            effects.speed_rpm,
        )
    for key in ("speed_rpm", "support_expansion_per_K"):
        if getattr(effects, key) is not None:
            _check_elements(asked, key)


def _check_tip_contact(asked: SceneFile) -> None:
    """Cams and followers have no tips that could be left out."""
    if not asked.effects.tip_contact and isinstance(asked.body_2, Cam):
        _refuse(
            "effects.tip_contact",
            "true with body_2.kind 'cam', which has neither tips nor fillets",
            False,
        )


def _check_elements(asked: SceneFile, key: str) -> None:
    """Growth beside what holds a body, or by its speed, is a load of finite elements."""
    if asked.effects.body == "tooth" and not (asked.body_1.rigid and asked.body_2.rigid):
        why = "effects.body is 'tooth': how a body grows is a matter of all its sectors"
        _refuse(f"effects.{key}", f"nothing, since {why}", getattr(asked.effects, key))
    for name, spec in (("body_1", asked.body_1), ("body_2", asked.body_2)):
        if isinstance(spec, ComplianceBody) and not spec.rigid:
            why = f"{name}.kind is 'compliance': its file does not say how it grows"
            _refuse(f"effects.{key}", f"nothing, since {why}", getattr(asked.effects, key))


def _of_both(value: float | tuple[float, ...] | None) -> tuple[float, ...]:
    """A number for each body; 0 where there is none."""
    return value if isinstance(value, tuple) else (value or 0.0,) * 2


def _check_places(asked: SceneFile) -> None:
    """A lumped contact has one place for its forces."""
    if asked.effects.contact != "lumped":
        return
    for key, value in (("near_field", "nodes"), ("influence", "finite")):
        if getattr(asked.effects, key) == value:
            _refuse(
                "effects.contact",
                f"'pairs' with effects.{key} '{value}': forces there have places",
                "lumped",
            )


def _check_nodes(asked: SceneFile) -> None:
    """Both flanks have nodes for forces, and nothing stands in modes."""
    if asked.effects.near_field != "nodes":
        return
    key = "effects.near_field"
    if isinstance(asked.body_2, Cam):
        _refuse(
            key,
            "'analytic' with body_2.kind 'cam': a closed flank has no first and last node",
            "nodes",
        )
    for name, body in (("body_1", asked.body_1), ("body_2", asked.body_2)):
        profile = body.profile if isinstance(body, MeshBody) else None
        for rounding in ("tip_radius_mm", "tip_chamfer_mm") if profile is not None else ():
            if getattr(profile, rounding) is not None:
                _refuse(
                    key,
                    f"'analytic' with {name}.profile.{rounding}: the edges of a file's flank set "
                    "that carry end where the tip turns",
                    "nodes",
                )
    for growth in ("temperature_rise_K", "speed_rpm"):
        if getattr(asked.effects, growth):
            _refuse(
                key, f"'analytic' with effects.{growth}: growth is known in modes alone", "nodes"
            )
    if asked.accuracy.modes is not None:
        _refuse(
            "accuracy.modes",
            f"nothing with {key} 'nodes': forces at nodes stand in place of modes",
            asked.accuracy.modes,
        )


def _check_coast_flank(asked: SceneFile) -> None:
    """Both flanks of every tooth are known, and something yields between them."""
    effects = asked.effects
    if not effects.coast_flank:
        return
    check_coast_kinds(asked.body_1.kind, asked.body_2.kind)
    if asked.body_1.rigid and asked.body_2.rigid:
        raise SceneError(
            key="effects.coast_flank",
            expected="false with body_1.rigid and body_2.rigid: flanks that press on each other "
            "across a tooth must yield",
            found="true",
        )
    if effects.contact == "lumped":
        raise SceneError(
            key="effects.contact",
            expected="'pairs' with effects.coast_flank: lumped contact has working flanks only",
            found="'lumped'",
        )
    for key, value in (("near_field", "nodes"), ("influence", "finite")):
        if getattr(effects, key) == value:
            _refuse(
                f"effects.{key}",
                "no such level with effects.coast_flank, whose flanks cross the teeth in modes, by "
                "small forces",
                value,
            )
    if effects.root_stress:
        raise SceneError(
            key="effects.root_stress",
            expected="false with effects.coast_flank: stress is known of forces on the working "
            "flanks only",
            found="true",
        )
