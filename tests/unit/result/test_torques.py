"""Results of a list of torques: one `Result` whose arrays have an axis of torques."""

import json
import pickle
from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.result import results_to_csv, results_to_json, results_to_text
from flankload.result.loaded_positions import PairPositions
from tests.support.made_up_result import made_up_result
from tests.support.paths import SCENES
from tests.support.solving import PARTS

FEW = {"accuracy.estimate": False, "accuracy.tangents": False, "positions.count": 2}
SCENE = fl.read_scene(SCENES / "external_gear.toml").replace(
    {**FEW, "effects.friction_coefficient": 0.05}
)
TORQUES = [5.0, 100.0]


@cache
def solved(*torques: float) -> fl.Result:
    """The scene with a list of torques; elements are solved once."""
    prepared = fl.Prepared.__new__(fl.Prepared)
    prepared.scene, prepared.parts = SCENE, PARTS
    return prepared.solve({"load.torque_Nm": list(torques)})


def made_up() -> fl.Result:
    """Two torques with different pairs."""
    light, heavy = made_up_result(torque_Nm=100.0), made_up_result(torque_Nm=302.0)
    values: dict[str, Any] = {
        key: getattr(light, key)[:, 1:]
        for key in ("site_force_N", "peak_pressure_MPa", "corner_contact")
    }
    light = made_up_result(
        torque_Nm=100.0, sites=light.sites[1:], outside_limits=("a",), estimate=None, **values
    )
    return fl.Result.of_torques([light, heavy])


def test_a_list_of_torques_is_one_result_with_an_axis_of_torques() -> None:
    found = solved(*TORQUES)
    assert isinstance(found, fl.Result)
    np.testing.assert_array_equal(found.torques_Nm, TORQUES)
    np.testing.assert_array_equal(found.torque_Nm, TORQUES)
    assert found.position_rad.shape == (2,)
    assert found.transmission_error_um.shape == (2, 2)
    assert found.load_share.shape == (2, 2, found.sites.size)
    np.testing.assert_allclose(found.load_share.sum(axis=2), 1.0)
    for t, torque in enumerate(TORQUES):
        one = found.at(torque)
        assert one.by_torque == (one,)
        np.testing.assert_array_equal(one.torques_Nm, [torque])
        np.testing.assert_array_equal(found.rotation_rad[t], one.rotation_rad)
        for name in ("rotation_rad", "site_force_N", "transmission_error_um", "load_share"):
            assert np.shares_memory(getattr(found, name), getattr(one, name)), name
        assert found.summary["peak_pressure_MPa"][t] == one.summary["peak_pressure_MPa"]
        assert found.friction[t] is one.friction
        assert found.cost["of_this_torque"][t] == one.cost["of_this_torque"]
        assert found.pairs(1)[t].site.tolist() == one.pairs(1).site.tolist()
    assert found.cost["stages"] == found.by_torque[0].cost["stages"]
    assert found.drive is None


def test_a_list_of_a_single_torque_has_the_axis_too() -> None:
    assert solved(100.0).site_force_N.shape[0] == 1
    one = solved(*TORQUES).at(100.0)
    np.testing.assert_allclose(solved(100.0).rotation_rad[0], one.rotation_rad, rtol=1e-12)


def test_pairs_of_all_torques_are_in_one_array() -> None:
    found = made_up()
    light, heavy = found.by_torque
    np.testing.assert_array_equal(found.sites, [-1, 0, 1])
    assert not found.site_force_N[0, :, 0].any()
    assert np.isnan(found.contact_half_width_mm[0, :, 0]).all()
    assert (found.flank_face_load_factor[0] == 1.0).all()
    assert found.corner_contact.dtype == bool
    np.testing.assert_array_equal(found.site_force_N[0, :, 1:], light.site_force_N)
    np.testing.assert_array_equal(found.site_force_N[1], heavy.site_force_N)
    assert found.warnings == light.warnings
    assert found.outside_limits == ("a",)
    assert found.estimate["transmission_error"] == (None, 1e-3)
    assert found.estimate["by_source"] == {"strips": {"transmission_error": (None, 1e-3)}}


def test_each_attribute_of_a_result_has_its_form_for_several_torques() -> None:
    found, one = made_up(), made_up_result()
    for name in (name for name in dir(one) if not name.startswith("_")):
        value, of_one = getattr(found, name), getattr(one, name)
        if isinstance(of_one, np.ndarray) and name not in ("sites", "torques_Nm", "slice_z_mm"):
            lead = () if name.startswith("position_") else (2,)
            assert value.shape == (*lead, *of_one.shape), name
            assert not value.flags.writeable, name


def test_each_property_says_whether_it_is_that_of_one_torque() -> None:
    """A plain property of the loads would be computed from arrays with the axis of torques."""
    common = {"by_torque", "has_torque_list", "torques_Nm", "plot"}
    common |= {"engagement", "words_for_sites", "slice_z_mm"}
    for base in fl.Result.__mro__:
        found = {name for name, value in vars(base).items() if isinstance(value, property)}
        assert base is PairPositions or found <= common, base


def test_unknown_torques_are_refused_with_those_that_exist() -> None:
    found = made_up()
    assert found.at(302.0 * (1 + 1e-14)) is found.by_torque[1]
    for wrong, shown in ((150, "150"), ("302", "'302'"), (None, "None")):
        with pytest.raises(fl.InputError) as caught:
            found.at(wrong)  # type: ignore[arg-type]
        assert str(caught.value) == f"torque_Nm: expected one of 100, 302, found {shown}"
    with pytest.raises(fl.InputError, match="expected one of 302, found 1"):
        made_up_result().at(1)


def test_files_and_texts_are_those_of_the_single_results() -> None:
    found = made_up()
    assert found.to_json() == results_to_json(found.by_torque) == results_to_json(found)
    assert list(json.loads(found.to_json())) == ["torques_Nm", "results"]
    assert list(json.loads(fl.Result.of_torques([made_up_result()]).to_json())) == [
        "torques_Nm",
        "results",
    ]
    assert found.to_csv() == results_to_csv(found.by_torque) == results_to_csv(found)
    assert found.table() == results_to_text(found.by_torque)
    assert found.stiffness_table().values["transmission_error_um"].shape == (33, 2)
    assert found.cost_table() == found.by_torque[0].cost_table()


def test_xarray_has_the_dimension_of_torques() -> None:
    pytest.importorskip("xarray")
    found = made_up()
    data = found.to_xarray()
    assert data.sizes == {"torque": 2, "position": 32, "site": 3, "slice": 1}
    assert data.torque.attrs["units"] == "N m"
    assert data.attrs["warnings"] == list(found.warnings)
    for name in data.data_vars:
        np.testing.assert_array_equal(data[name].to_numpy(), getattr(found, name))


def test_results_of_several_torques_come_back_from_a_pickle() -> None:
    found = made_up()
    assert found.load_share.shape == (2, 32, 3)
    again = pickle.loads(pickle.dumps(found))
    assert again.has_torque_list
    np.testing.assert_array_equal(again.load_share, found.load_share)
    assert not again.load_share.flags.writeable
    assert again.at(302).torque_Nm == 302.0


def test_results_at_different_positions_are_not_joined() -> None:
    with pytest.raises(ValueError, match="results: expected the same positions"):
        fl.Result.of_torques([made_up_result(), made_up_result(count=16)])
    with pytest.raises(ValueError, match="found none"):
        fl.Result.of_torques([])


def test_angles_are_known_in_degrees() -> None:
    one = made_up_result(unloaded_rotation_rad=np.zeros(32))
    for name in ("position", "rotation", "unloaded_rotation", "pitch", "period"):
        np.testing.assert_allclose(
            getattr(one, f"{name}_deg"), np.degrees(getattr(one, f"{name}_rad"))
        )
    assert made_up_result().follower_angle_deg is None
