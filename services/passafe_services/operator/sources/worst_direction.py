"""Worst-case directions of an adversary operator, as expressions of state, input in force and time."""

from collections.abc import Sequence

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.models.task_frame import TaskFrame
from passafe.symbolic.rows import TINY
from passafe.system import System


def against_h(system: System, chains: Sequence[BarrierChain]) -> ca.SX:
    """Return the direction into the tightest safety row, shape (m, 1), largest component 1.

    That is −∇_u ψ_r of the barrier with the smallest ψ_r(x, u, t)/‖∇_u ψ_r‖, the distance of u from its row in units of
    u; the first axis if the input has no effect on any barrier.

    Args:
        system: The plant.
        chains: Chains of its barriers.
    """
    least, gradient = ca.SX(ca.inf), ca.SX.zeros(system.m)
    for chain in chains:
        slope = ca.gradient(chain.psi[-1], system.u)
        length = ca.norm_2(slope)
        distance = ca.if_else(length > TINY, chain.psi[-1] / ca.fmax(length, TINY), ca.inf)
        nearer = distance < least
        least = ca.if_else(nearer, distance, least)
        gradient = ca.if_else(nearer, slope, gradient)
    return _pointed(-gradient)


def against_the_tank(system: System, h_u: ca.SX) -> ca.SX:
    """Return the direction of steepest descent of the power margin, −∇_u h_u, scaled as in ``against_h``.

    Args:
        system: The plant.
        h_u: Its power margin, expression of x and u.
    """
    return _pointed(-ca.gradient(h_u, system.u))


def through_task(task: TaskFrame, direction: ca.SX) -> ca.SX:
    """Return the command that pushes the input most along a direction, from a command of zero on, scaled likewise.

    Args:
        task: Frame of the commands.
        direction: Of the input, shape (m, 1).
    """
    effect = ca.substitute(ca.jacobian(task.u_h, task.command), task.command, ca.SX.zeros(task.size))
    return _pointed(effect.T @ direction)


def _pointed(direction: ca.SX) -> ca.SX:
    """Scale a direction to largest component 1; the first axis for a zero direction."""
    size = ca.mmax(ca.fabs(direction))
    first = ca.DM.zeros(direction.numel())
    first[0] = 1.0
    return ca.if_else(size > TINY, direction / ca.fmax(size, TINY), first)
