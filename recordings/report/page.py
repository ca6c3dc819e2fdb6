"""The report as one HTML page: no script, nothing from the network, light and dark as the reader's system is."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from markupsafe import Markup

from movingout.maps.spec import SEAT_COLOURS, MapSpec
from movingout.recordings.html_page import templates
from movingout.recordings.report import svg
from movingout.recordings.report.failures import TITLES
from movingout.recordings.report.measures import MEASURES, MeasureDisplay, in_words
from movingout.recordings.report.method import rules
from movingout.recordings.report.tally import Group, ReportTally, Strip
from movingout.recordings.report.waiting import Wait
from movingout.world.constants import TICK_SECONDS
from movingout.world.metrics import METRICS

MOST_LISTED = 300  # findings per case; the JSON output has all
MOST_ABREAST = 4  # populations of a map in one row
STRIPS = 5  # episodes with the most waiting, per group
CHARTED = ("success", *(metric.key for metric in METRICS), "seconds")


class KeyFigure(NamedTuple):
    """A large number at the top."""

    name: str
    value: str
    note: str


class MeasureChart(NamedTuple):
    """A measure by map and population."""

    measure: MeasureDisplay
    picture: Markup


@dataclass(frozen=True, slots=True)
class ReportPage:
    """What `page.html.j2` shows."""

    folder: str
    server: str  # base address of a running `movingout play` that has these recordings
    tally: ReportTally

    def html(self) -> str:
        template = templates(Path(__file__).parent).get_template("page.html.j2")
        return template.render(
            page=self,
            tally=self.tally,
            title=f"Report on {self.folder}",
            measures=MEASURES,
            titles=TITLES,
            rules=rules(),
            colours=SEAT_COLOURS,
            legend_mark=svg.legend_mark,
            most_listed=MOST_LISTED,
            tick_seconds=TICK_SECONDS,
        )

    @property
    def lead(self) -> str:
        """How many recordings, from which days."""
        tally = self.tally
        days = sorted({tally.first[:10], tally.last[:10]} - {""})
        return " · ".join([f"{tally.episodes + tally.unfinished} recordings", *([" to ".join(days)] if days else [])])

    @property
    def unfinished(self) -> str:
        """What is left out of the averages."""
        count = self.tally.unfinished
        recordings = "recording is" if count == 1 else "recordings are"
        return f"{count} unfinished {recordings} left out of the averages."

    @property
    def tutorials(self) -> str:
        """What is left out of the whole page."""
        count = self.tally.tutorials
        return f"{count} {'recording' if count == 1 else 'recordings'} of tutorials left out."

    @property
    def figures(self) -> list[KeyFigure]:
        tally = self.tally
        success, tcr, waiting = (in_words(tally.overall(name), name) for name in ("success", "tcr", "wt_s"))
        affected = len({one.facts.id for one in tally.found})
        return [
            KeyFigure("Everything delivered", success, f"{tally.episodes} episodes"),
            KeyFigure("Task completion rate", tcr, "all maps and populations"),
            KeyFigure("Waiting time", waiting, "both seats together, per episode"),
            KeyFigure("Failure cases found", str(len(tally.found)), f"in {affected} recordings"),
        ]

    @property
    def charts(self) -> list[MeasureChart]:
        return [self._chart(name) for name in CHARTED]

    @property
    def columns(self) -> int:
        """The most populations of a map, as far as they stand side by side."""
        return min(max(len(groups) for _, groups in self.tally.by_map()), MOST_ABREAST)

    def arena(self, group: Group) -> Markup:
        return svg.arena(group.map, group.presence, items=group.variants == {group.map.variant})

    def consistency(self, group: Group) -> Markup:
        return svg.curves([("", group.consistency_over_time())], "Action consistency over time")

    def waiting(self, group: Group) -> Markup:
        waiting = group.waiting_over_time()
        series = [("blue", waiting[:, 0]), ("red", waiting[:, 1])]
        return svg.curves(series, "Share of episodes in which each seat waits, over time")

    def strips(self, group: Group) -> list[Markup]:
        """The episodes with the most waiting, along their time."""
        longest = max(strip.ticks for strip in group.strips)
        return [self._strip(group.map, strip, longest) for strip in group.longest_waits(STRIPS)]

    def link(self, episode_id: str, tick: int) -> str:
        """The replay at a tick."""
        return f"{self.server.rstrip('/')}/replay/{quote(episode_id, safe='')}#tick={tick}"

    def _chart(self, name: str) -> MeasureChart:
        measure, places = MEASURES[name], {pair: place for place, pair in enumerate(self.tally.populations)}
        factor = 100.0 if measure.unit == "%" else 1.0
        rows: list[tuple[str, list[svg.Dot]]] = []
        for spec, groups in self.tally.by_map():
            row = []
            for group in groups:
                if (found := group.estimate(name)) is not None:
                    title = f"{group.population[0]} with {group.population[1]}: {in_words(found, name)}, n = {found.n}"
                    half = factor * (found.stderr or 0.0)
                    row.append(svg.Dot(places[group.population], factor * found.mean, half, title))
            rows.append((spec.title, row))
        low, high = measure.scale or _range([dot for _, row in rows for dot in row])
        return MeasureChart(measure, svg.dots(rows, low, high, f"{measure.name} by map, mean and standard error"))

    def _strip(self, spec: MapSpec, strip: Strip, longest: int) -> Markup:
        segments = [
            svg.Segment(
                seat=wait.seat,
                start=wait.start / strip.ticks,
                end=wait.end / strip.ticks,
                href=self.link(strip.id, wait.start),
                title=_waited(spec, wait),
            )
            for wait in strip.waits
        ]
        total = sum(wait.seconds for wait in strip.waits)
        return svg.strip(segments, strip.ticks / longest, f"Episode {strip.id}: {total:.1f} s of waiting")


def _range(dots: Sequence[svg.Dot]) -> tuple[float, float]:
    """From 0, or below where something is, to the largest end of an interval."""
    low = min((dot.mean - dot.half for dot in dots), default=0.0)
    high = max((dot.mean + dot.half for dot in dots), default=1.0)
    return min(low, 0.0), max(high, 1.0)


def _waited(spec: MapSpec, wait: Wait) -> str:
    item = spec.items[wait.item] if wait.item < len(spec.items) else None
    what = f"the {item.size} {item.shape}" if item else "an item"
    return (
        f"{SEAT_COLOURS[wait.seat]} held {what} alone for {wait.seconds:.1f} s, from {wait.start * TICK_SECONDS:.1f} s"
    )
