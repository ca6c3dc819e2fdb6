"""An episode in a notebook: a figure of the whole of it, and a pandas table."""

from collections.abc import Sequence
from html import escape
from typing import Any

from movingout.maps.extras import needs_extra
from movingout.maps.render import SvgPicture, arena_svg
from movingout.maps.scene import LIGHT, Disc, Line, SceneState, Shape, backdrop, movers
from movingout.maps.spec import ROBOT_RADIUS
from movingout.recordings.episode import Episode
from movingout.recordings.exports.tables import TICKS, observation_columns, tick_rows
from movingout.recordings.file_format.derived_topics import curves
from movingout.world.constants import TICK_SECONDS
from movingout.world.metrics import METRICS, Metric
from movingout.world.observation import layout_named
from movingout.world.state import Floats

_SIDE = 420  # pixels of the arena
_CHART_WIDTH, _CHART_LEFT, _CHART_GAP = 300, 44, 14
_WAY, _ITEM_WAY = 0.014, 0.008  # arena units
_SHORTEST = 1e-3  # arena units: of a line worth drawing


def episode_figure(episode: Episode) -> SvgPicture:
    """The map at the end with the ways of robots and items, and beside it a chart per metric that has a value."""
    header = episode.header
    title = f"{header.map.title}: {header.seats[0].name} (blue) and {header.seats[1].name} (red)"
    values = curves(episode)
    charts = [metric for metric in METRICS if any(value is not None for value in values[metric.key])]
    width, height = _SIDE + _CHART_GAP + _CHART_WIDTH, _SIDE + 24
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'role="img" font-family="system-ui, sans-serif" font-size="12">',
        f"<title>{escape(title)}</title>",
        f'<rect width="{width}" height="{height}" fill="{LIGHT.surface}"/>',
        f'<text x="4" y="16" font-weight="600" fill="{LIGHT.ink}">{escape(title)}</text>',
        f'<g transform="translate(0 24)">{arena_svg(_shapes(episode), _SIDE)}</g>',
    ]
    share = _SIDE / max(len(charts), 1)
    for row, metric in enumerate(charts):
        place = f"translate({_SIDE + _CHART_GAP} {24 + row * share:.1f})"
        parts.append(f'<g transform="{place}">{_chart(metric, values[metric.key], share)}</g>')
    return SvgPicture("\n".join([*parts, "</svg>"]) + "\n")


def _shapes(episode: Episode) -> list[Shape]:
    """The map, the way of every body, a ring where each robot started, and where everything is at the end."""
    states, spec = episode.states, episode.header.map
    end = states[-1]
    shapes = backdrop(spec)
    for item in range(len(spec.items)):
        shapes += _way([state.item_poses[item] for state in states], LIGHT.small, _ITEM_WAY)
    for seat, colour in enumerate((LIGHT.blue, LIGHT.red)):
        x, y, _ = states[0].robot_poses[seat].tolist()
        shapes.append(Disc((x, y), ROBOT_RADIUS, stroke=colour, width=_ITEM_WAY))
        shapes += _way([state.robot_poses[seat] for state in states], colour, _WAY)
    delivered = episode.delivered_after(len(episode.ticks))
    final = SceneState(end.robot_poses.tolist(), end.item_poses.tolist(), end.held.tolist(), delivered)
    return shapes + movers(spec, final)


def _way(poses: Sequence[Floats], colour: str, width: float) -> list[Shape]:
    """The line through the places of a body, without those where it stands; none for a body that never moves."""
    points: list[tuple[float, float]] = []
    for pose in poses:
        x, y, _ = pose.tolist()
        if not points or abs(x - points[-1][0]) + abs(y - points[-1][1]) > _SHORTEST:
            points.append((x, y))
    return [Line(tuple(points), colour, width, round=True)] if len(points) > 1 else []


def _chart(metric: Metric, values: Sequence[float | None], height: float) -> str:
    """A metric over time: its title with the final value, the line, the range and the seconds."""
    known = [value for value in values if value is not None]
    low = min(0.0, *known) if metric.low is None else metric.low
    high = max(known) if metric.high is None else metric.high
    high = high if high > low else low + 1.0  # nobody waited, say
    top, bottom, right = 20.0, height - 22, _CHART_WIDTH - 4
    across = (right - _CHART_LEFT) / max(len(values) - 1, 1)
    points = " ".join(
        f"{_CHART_LEFT + tick * across:.1f},{bottom - (value - low) / (high - low) * (bottom - top):.1f}"
        for tick, value in enumerate(values)
        if value is not None
    )
    seconds = len(values) * TICK_SECONDS
    title = f"{metric.title}: {metric.text(values[-1])}"
    scale = f'font-size="10" fill="{LIGHT.large}"'
    return "".join(
        (
            f'<text x="{_CHART_LEFT}" y="14" fill="{LIGHT.ink}">{escape(title)}</text>',
            f'<path d="M{_CHART_LEFT} {top}V{bottom:.1f}H{right}" fill="none" stroke="{LIGHT.small}"/>',
            f'<polyline points="{points}" fill="none" stroke="{LIGHT.ink}" stroke-width="1.5"/>',
            f'<text x="{_CHART_LEFT - 4}" y="{top + 8}" text-anchor="end" {scale}>{high:.3g}</text>',
            f'<text x="{_CHART_LEFT - 4}" y="{bottom:.1f}" text-anchor="end" {scale}>{low:.3g}</text>',
            f'<text x="{right}" y="{bottom + 13:.1f}" text-anchor="end" {scale}>{seconds:g} s</text>',
        )
    )


def episode_frame(episode: Episode, layout: str) -> Any:
    """A pandas DataFrame of `tick_rows`. Raises MissingExtraError without pandas, WorldError for an unknown layout."""
    with needs_extra("notebook", "to_frame (pandas)"):
        import pandas
    if layout:
        layout_named(layout)  # says which there are
    columns = [*TICKS, *(observation_columns(layout) if layout else [])]
    rows = list(tick_rows(episode, layout))
    frame = pandas.DataFrame(rows, columns=[column.name for column in columns])
    types = {"float64": "float64", "bool": "boolean"}  # the same for every map, whose items may be fewer
    dtypes = {column.name: types[column.type] for column in columns if column.type in types}
    begun = {column.name: "Int64" for column in columns if column.type == "int64" and column.name not in rows[0]}
    return frame.astype(dtypes | begun)
