"""Layout file of Foxglove and Lichtblick for a run: scene, plots by name, statuses and log lines."""

import json
from collections.abc import Mapping
from typing import Any, Final

from passafe_services.tables.columns import Column
from passafe_services.tables.layout import TableLayout
from passafe_services.viewer.log_lines import LINES
from passafe_services.viewer.scene import BARRIERS, POSES, ROBOT, WORLD

_COLOURS: Final = ("#1f6fd6", "#d95f02", "#1b9e77", "#7570b3", "#e7298a", "#66a61e", "#e6ab02", "#a6761d")


def layout_json(layouts: Mapping[str, TableLayout]) -> str:
    """Return the layout for the tables of a run, as the viewers import it.

    Args:
        layouts: Complete layout of each table, by name of the topic.
    """
    tick, state = layouts["tick"].columns, layouts["state"].columns
    inputs = [*_paths("tick", tick, "u_nominal_"), *_paths("tick", tick, "u_", digits_only=True)]
    panels: dict[str, Any] = {
        "3D!scene": _scene(),
        "Plot!barriers": _plot("Barriers h", _paths("tick", tick, "barrier_", ending="psi_0")),
        "Plot!energy": _plot("Power margin and tank", ["/passafe/tick.power_margin", "/passafe/tick.tank_j"]),
        "Plot!inputs": _plot("Input asked for and sent", inputs),
        "Plot!states": _plot("State", _paths("state", state, "x_", digits_only=True)),
        "Plot!ages": _plot("Ages, ns", ["/passafe/tick.state_age_ns", "/passafe/tick.command_age_ns"]),
        "StateTransitions!status": {
            "paths": [{"value": f"/passafe/{path}", "timestampMethod": "receiveTime"} for path in STATUSES],
            "isSynced": True,
        },
        "RosOut!log": {"topicToRender": LINES.name, "searchTerms": [], "minLogLevel": 1},
    }
    left = _split("column", "3D!scene", _split("column", "StateTransitions!status", "RosOut!log"), 60)
    right = _split(
        "column",
        _split("column", "Plot!barriers", "Plot!energy"),
        _split("column", "Plot!inputs", _split("row", "Plot!states", "Plot!ages")),
    )
    return json.dumps(
        {
            "configById": panels,
            "globalVariables": {},
            "userNodes": {},
            "playbackConfig": {"speed": 1},
            "layout": _split("row", left, right, 42),
        },
        indent=2,
    )


STATUSES: Final = ("tick.status", "tick.command_state", "state.phase")


def _paths(
    table: str, columns: tuple[Column, ...], beginning: str, *, ending: str = "", digits_only: bool = False
) -> list[str]:
    names = [column.name for column in columns if column.name.startswith(beginning) and column.name.endswith(ending)]
    if digits_only:
        names = [name for name in names if name.removeprefix(beginning).isdigit()]
    return [f"/passafe/{table}.{name}" for name in names]


def _plot(title: str, paths: list[str]) -> dict[str, Any]:
    series = [
        {"value": path, "enabled": True, "timestampMethod": "receiveTime", "color": _COLOURS[k % len(_COLOURS)]}
        for k, path in enumerate(paths)
    ]
    return {
        "title": title,
        "foxglovePanelTitle": title,
        "paths": series,
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "isSynced": True,
        "xAxisVal": "timestamp",
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "sidebarDimension": 240,
    }


def _scene() -> dict[str, Any]:
    return {
        "foxglovePanelTitle": "Scene",
        "followMode": "follow-none",
        "followTf": WORLD,
        "fixedFrame": WORLD,
        "cameraState": {
            "perspective": False,
            "distance": 6,
            "phi": 0,
            "thetaOffset": 0,
            "targetOffset": [0, 0, 0],
            "target": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": 45,
            "near": 0.5,
            "far": 5000,
        },
        "scene": {},
        "transforms": {},
        "topics": {topic.name: {"visible": True} for topic in (BARRIERS, ROBOT, POSES)},
        "layers": {
            "grid": {
                "layerId": "foxglove.Grid",
                "instanceId": "grid",
                "visible": True,
                "frameLocked": True,
                "label": "Grid",
                "size": 10,
                "divisions": 10,
                "lineWidth": 1,
                "color": "#9ca3af55",
                "position": [0, 0, 0],
                "rotation": [0, 0, 0],
            }
        },
    }


def _split(direction: str, first: object, second: object, percentage: int = 50) -> dict[str, object]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": percentage}
