"""A hand that pushes a simulated robot now and then, in directions drawn from a seed."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from passafe_services.drivers.errors import DriverError
from passafe_services.scenarios.driver_schema import HandConfig

if TYPE_CHECKING:
    import mujoco


@dataclass(frozen=True, kw_only=True, slots=True)
class Hand:
    """Pushes one body.

    Attributes:
        body: Its number.
        config: Part of a scenario.
    """

    body: int
    config: HandConfig

    @classmethod
    def of(cls, model: "mujoco.MjModel", config: HandConfig) -> "Hand":
        """Return the hand of a scenario.

        Raises:
            DriverError: No such body.
        """
        names = [model.body(i).name for i in range(1, model.nbody)]
        if config.body not in names:
            raise DriverError("mujoco", f"no body {config.body!r} to push", f"one of {names}")
        return cls(body=names.index(config.body) + 1, config=config)

    def push(self, data: "mujoco.MjData") -> None:
        """Set the force of the present instant: the same at the same time, whatever was before."""
        number, since_s = divmod(float(data.time), self.config.every_s)
        force = np.zeros(3)
        if since_s < self.config.for_s:
            direction = np.random.default_rng((self.config.seed, int(number))).normal(size=3)
            force = self.config.force_n * direction / np.linalg.norm(direction)
        data.xfrc_applied[self.body, :3] = force
