"""MuJoCo as the robot: against the core's own arm, with contacts, friction and a hand."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from passafe_services.drivers.errors import DriverError
from passafe_services.scenarios.driver_schema import HandConfig, MujocoDriverConfig

from passafe import SampledPlant, damped_point
from passafe.models.seven_joint_arm import SPHERES, TOP_TORQUE, joint_torques, seven_joint_arm

mujoco = pytest.importorskip("mujoco")
module = pytest.importorskip("passafe_services.drivers.mujoco_driver")
MujocoDriver, LARGEST_LAG = module.MujocoDriver, module.LARGEST_LAG

MS = 1_000_000
ARM = seven_joint_arm(sigma=1.0, gamma_1=8.0, dt_s=1e-3)
PLANT = SampledPlant(ARM.system, ARM.storage, 1e-3)
START = (0.0, -0.5, 0.0, -2.2, 0.0, 1.7, 0.8, *(0.0,) * 7)
POINT_PLANT = SampledPlant(damped_point().system, damped_point().system.x[0] ** 2 * 0, 1e-3)
POINT = """<mujoco><option gravity="0 0 0" timestep="0.0003"/><worldbody>
<geom name="wall" type="box" pos="1.1 0 0" size="0.1 1 1"/>
<body name="cart"><joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
<geom name="ball" size="0.1" mass="2"/></body></worldbody>
<actuator><motor joint="x"/><motor joint="y"/></actuator></mujoco>"""


def driver_of(**changes: object) -> "MujocoDriver":
    config = MujocoDriverConfig(kind="mujoco", mjcf="seven-joint-arm")
    return MujocoDriver(config.model_copy(update=changes), PLANT, x0=START, period_ns=MS)


def course(driver: "MujocoDriver", u: tuple[float, ...], periods: int) -> np.ndarray:
    states = []
    for k in range(periods):
        driver.apply(u, k * MS)
        reading = driver.read((k + 1) * MS)
        states.append(reading.true_x or reading.x)
    return np.array(states)


def test_its_arm_has_the_cores_dynamics() -> None:
    driver, rng = driver_of(), np.random.default_rng(2)
    q, v, a = (ca.SX.sym(name, 7) for name in "qva")
    torques = ca.Function("torques", [q, v, a], [joint_torques(q, v, a)])
    model, data = driver._worlds.nominal, driver._twin
    for _ in range(5):
        data.qpos[:], data.qvel[:] = rng.uniform(-1, 1, 7), rng.normal(size=7)
        acceleration, found = rng.normal(size=7), np.zeros(7)
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_mulM(model, data, found, acceleration)
        expected = np.array(torques(data.qpos, data.qvel, acceleration)).ravel()
        assert found + data.qfrc_bias == pytest.approx(expected, abs=1e-6)


def test_its_geoms_lie_within_the_arms_spheres() -> None:
    driver = driver_of()
    model, data = driver._worlds.true, driver._data
    centres = ca.Function("centres", [ARM.system.x], [ca.horzcat(*(sphere.centre for sphere in ARM.spheres))])
    places, radii = np.array(centres(START)).T, np.array([place.radius_m for place in SPHERES.values()])
    capsules = [g for g in range(model.ngeom) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_CAPSULE]
    assert len(capsules) == 6
    for g in capsules:
        radius, half = model.geom_size[g][:2]
        frame = data.geom_xmat[g].reshape(3, 3)
        for along in np.linspace(-half - radius, half + radius, 41):
            wide = np.sqrt(max(radius**2 - max(abs(along) - half, 0.0) ** 2, 0.0))
            for turn in np.linspace(0, 2 * np.pi, 13):
                point = data.geom_xpos[g] + frame @ (wide * np.cos(turn), wide * np.sin(turn), along)
                assert (radii - np.linalg.norm(places - point, axis=1)).max() > 0.005


def test_it_rests_until_an_input_comes_and_starts_anew() -> None:
    driver = driver_of()

    assert driver.read(500 * MS).x == START
    course(driver, (1.0,) * 7, 20)
    driver.open()
    assert driver.read(900 * MS).x == START
    driver.close()


def test_joints_follow_their_reference_in_spite_of_friction() -> None:
    u, x, lag = (0.5, -0.5, 0.5, 0.5, -0.5, 0.5, 0.5), START, 0.0
    driver = driver_of(friction_n_m=0.5, mass_scale=1.05)
    for k in range(400):
        driver.apply(u, k * MS)
        reading = driver.read((k + 1) * MS)
        x = PLANT.advance(x, u).x
        lag = max(lag, np.abs(np.subtract(reading.x, reading.true_x)[:7]).max())

    assert reading.x == x  # the reference is the model
    assert 1e-4 < lag < 5e-3


def test_a_reference_is_drawn_after_joints_that_are_held() -> None:
    driver = driver_of(friction_n_m=1e3)
    for k in range(800):
        driver.apply((1.0,) * 7, k * MS)
        reading = driver.read((k + 1) * MS)

    assert np.abs(np.subtract(reading.x, reading.true_x)[:7]).max() <= LARGEST_LAG + 1e-12


def test_equal_runs_are_equal_to_the_last_bit() -> None:
    hand = HandConfig(body="link4", force_n=30.0, every_s=0.05, for_s=0.02)

    first, second = (course(driver_of(hand=hand, friction_n_m=0.5), (1.0,) * 7, 100) for _ in range(2))

    assert (first == second).all()
    assert np.abs(first - course(driver_of(friction_n_m=0.5), (1.0,) * 7, 100)).max() > 1e-4


def test_torques_end_at_the_joints_limits() -> None:
    driver = driver_of()
    driver.apply((1e4,) * 7, 0)
    driver.read(MS)

    assert np.abs(driver._data.qfrc_applied) == pytest.approx(TOP_TORQUE)


def point_driver(tmp_path: Path, **changes: object) -> "MujocoDriver":
    path = tmp_path / "point.xml"
    path.write_text(POINT)
    config = MujocoDriverConfig(kind="mujoco", mjcf=str(path), control="actuators", **changes)
    return MujocoDriver(config, POINT_PLANT, x0=(0.0,) * 4, period_ns=MS)


def test_any_model_is_moved_by_its_actuators(tmp_path: Path) -> None:
    x = course(point_driver(tmp_path), (4.0, 0.0), 500)[-1]

    assert x[:3] == pytest.approx([0.25, 0.0, 1.0], abs=2e-3)  # 2 kg, 4 N, 0.5 s


def test_the_distance_is_mujocos_own(tmp_path: Path) -> None:
    driver = point_driver(tmp_path)

    course(driver, (4.0, 0.0), 500)
    assert driver.least_distance_m == pytest.approx(1.0 - 0.1 - 0.25, abs=2e-3)
    course(driver, (40.0, 0.0), 500)
    assert driver.least_distance_m < 0.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mjcf": "none.xml"}, "no file none.xml, allowed a shipped model, or the path of an MJCF file"),
        ({"mjcf": __file__}, "an MJCF file"),
        ({"joints": ("joint1", "knee")}, "the joints \\['knee'\\], allowed one of"),
        ({"joints": ("joint1",)}, "1 joints for 7 coordinates"),
        ({"hand": HandConfig(body="foot", force_n=1.0)}, "no body 'foot' to push, allowed one of"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, object], message: str) -> None:
    with pytest.raises(DriverError, match=message):
        driver_of(**changes)


def test_joints_of_several_coordinates_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "ball.xml"
    path.write_text(
        '<mujoco><worldbody><body><joint name="b" type="ball"/><geom size=".1"/></body></worldbody></mujoco>'
    )
    config = MujocoDriverConfig(kind="mujoco", mjcf=str(path))
    with pytest.raises(DriverError, match="hinges and slides"):
        MujocoDriver(config, POINT_PLANT, x0=(0.0, 0.0), period_ns=MS)
