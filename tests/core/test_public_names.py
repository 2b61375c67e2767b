import casadi as ca

import passafe


def test_what_is_promised_is_there_and_nothing_twice() -> None:
    assert all(hasattr(passafe, name) for name in passafe.__all__)
    assert sorted(set(passafe.__all__)) == passafe.__all__


def test_the_example_of_the_package_docstring_decides() -> None:
    robot = passafe.damped_point(sigma=1.0, gamma_1=10.0)
    gains = (passafe.Linear(gain=10.0), passafe.Linear(gain=10.0), passafe.Cubic(gain=100.0))
    disk = passafe.disk_keep_out(robot.position, centre=(0, 0), radius=1.0)
    design = passafe.FilterDesign(
        system=robot.system,
        u_fb=robot.proportional_derivative(k_p=10.0, k_d=5.0),
        fail_safe=robot.fail_safe,
        barriers=(passafe.Barrier(name="disk", h=disk, class_k=gains),),
        passivity=passafe.Passivity(V=ca.sumsqr(robot.system.x)),
        k_i=100.0,
        dt_s=1e-3,
        input_bound=100.0,
    )
    decision = passafe.SafetyPassivityFilter(design).decide((2, 2, -1, -1), (0, 0), (0, 0), (0, 0))

    assert decision.status in {passafe.Status.PASSED, passafe.Status.MODIFIED}
    assert len(decision.u) == 2
