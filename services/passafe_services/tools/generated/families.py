"""The families of generated plants."""

from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

import numpy as np

from passafe_services.tools.generated.design_timing import DesignTiming
from passafe_services.tools.generated.generated_plant import GeneratedPlant
from passafe_services.tools.generated.plants.actuators import quadratic, saturated
from passafe_services.tools.generated.plants.bicycle import bicycle
from passafe_services.tools.generated.plants.car_following import car_following
from passafe_services.tools.generated.plants.cart_pole import cart_pole
from passafe_services.tools.generated.plants.integrator_chain import integrator_chain
from passafe_services.tools.generated.plants.linear import stable, stiff, unstable
from passafe_services.tools.generated.plants.pendulum import pendulum
from passafe_services.tools.generated.plants.quadrotor import quadrotor
from passafe_services.tools.generated.plants.two_link_arm import two_link_arm
from passafe_services.tools.generated.plants.unicycle import unicycle

PlantDraw: TypeAlias = Callable[[np.random.Generator, DesignTiming], GeneratedPlant]

FAMILIES: Final[Mapping[str, PlantDraw]] = {
    "integrator-chain": integrator_chain,
    "stable": stable,
    "unstable": unstable,
    "stiff": stiff,
    "unicycle": unicycle,
    "bicycle": bicycle,
    "quadrotor": quadrotor,
    "cart-pole": cart_pole,
    "two-link-arm": two_link_arm,
    "pendulum": pendulum,
    "car-following": car_following,
    "saturated": saturated,
    "quadratic": quadratic,
}
"""By name; designs take turns through them."""
