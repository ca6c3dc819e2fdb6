"""The report as one HTML page: no script, nothing from the network, light and dark as the reader's system is."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from markupsafe import Markup

from movingout.maps.spec import SEAT_COLOURS, MapSpec
from movingout.recordings.html_page import templates
from movingout.recordings.report import svg
from movingout.recordings.report.failures import CASES
from movingout.recordings.report.measures import MEASURES, MeasureDisplay, in_words
from movingout.recordings.report.method import rules
from movingout.recordings.report.tally import Group, ReportTally, Strip
from movingout.recordings.report.waiting import Wait
from movingout.recordings.report.words import Words
from movingout.world.constants import TICK_SECONDS
from movingout.world.metrics import METRICS
from movingout.world.own_metrics import own_metrics

MOST_LISTED = 300  # findings per case; the JSON output has all
MOST_ABREAST = 4  # populations of a map in one row
MOST_NAMED = 4  # agents that one name stands for
STRIPS = 5  # episodes with the most waiting, per group
CHARTED = ("success", *(metric.key for metric in (*METRICS, *own_metrics())), "seconds")


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
    words: Words = field(default_factory=Words)

    def html(self) -> str:
        words, template = self.words, templates(Path(__file__).parent).get_template("page.html.j2")
        return template.render(
            page=self,
            tally=self.tally,
            words=words,
            say=words.say,
            language=words.language,
            title=words.say("report.title", folder=self.folder),
            measures=MEASURES,
            titles={case: words.say(f"case.{case}") for case in CASES},
            rules=rules(words),
            colours=SEAT_COLOURS,
            legend_mark=svg.legend_mark,
            most_listed=MOST_LISTED,
            tick_seconds=TICK_SECONDS,
        )

    @property
    def lead(self) -> str:
        """How many recordings, from which days."""
        tally, say = self.tally, self.words.say
        days = sorted({tally.first[:10], tally.last[:10]} - {""})
        when = [say("report.days", first=days[0], last=days[-1]) if len(days) > 1 else days[0]] if days else []
        return " · ".join([say("report.recordings", count=tally.episodes + tally.unfinished), *when])

    @property
    def figures(self) -> list[KeyFigure]:
        tally, say = self.tally, self.words.say
        success, tcr, waiting = (in_words(tally.overall(key), key, self.words) for key in ("success", "tcr", "wt_s"))
        affected = len({one.facts.id for one in tally.found})
        return [
            KeyFigure(say("measure.success"), success, say("report.episodes", count=tally.episodes)),
            KeyFigure(say("measure.tcr"), tcr, say("report.all_maps")),
            KeyFigure(say("measure.wt_s"), waiting, say("report.both_seats")),
            KeyFigure(say("report.cases_found"), str(len(tally.found)), say("report.in_recordings", count=affected)),
        ]

    @property
    def on_maps(self) -> list[str]:
        """What is to be known of the maps: that both challenges are here, and which are different maps of one name."""
        say, tally = self.words.say, self.tally
        both = [say("report.challenges")] if len(tally.challenges) > 1 else []
        for name, firsts in tally.maps_of_one_name.items():
            listed = [say("report.one_name.file", map=f"{name}.{k}", file=file) for k, file in enumerate(firsts, 1)]
            both.append(say("report.one_name", number=len(firsts), map=name, files=listed))
        return both

    @property
    def on_agents(self) -> list[str]:
        """Which names stand for several agents."""
        said = []
        for who, ids in self.tally.pooled.items():
            shown = [*ids[:MOST_NAMED], *(["…"] if len(ids) > MOST_NAMED else [])]
            said.append(self.words.say("report.pooled", who=self.name(who), number=len(ids), ids=shown))
        return said

    @property
    def charts(self) -> list[MeasureChart]:
        return [self._chart(name) for name in CHARTED]

    @property
    def columns(self) -> int:
        """The most populations of a map, as far as they stand side by side."""
        return min(max(len(groups) for _, groups in self.tally.by_map()), MOST_ABREAST)

    def name(self, population: str) -> str:
        """How a member of a population is called: ids of agents as they are."""
        return self.words.known(f"population.{population}", population)

    def count(self, group: Group) -> str:
        """How many episodes, and how many of them differ where some are equal."""
        if group.distinct == group.n:
            return str(group.n)
        return self.words.say("report.n.distinct", n=group.n, distinct=group.distinct)

    def title(self, spec: MapSpec) -> str:
        """That of a map, and whether it is varied."""
        title = self.words.map_title(spec)
        return self.words.say("report.varied", map=title) if spec.variant else title

    def arena(self, spec: MapSpec, group: Group) -> Markup:
        title = self.words.say("report.where.map", map=self.title(spec))
        return svg.arena(group.map, group.presence, title, items=group.variants == {group.map.variant})

    def consistency(self, group: Group) -> Markup:
        return svg.curves([("", group.consistency_over_time())], self.words.say("report.consistency"))

    def waiting(self, group: Group) -> Markup:
        waiting = group.waiting_over_time()
        series = [("blue", waiting[:, 0]), ("red", waiting[:, 1])]
        return svg.curves(series, self.words.say("report.waiting.curve"))

    def strips(self, group: Group) -> list[Markup]:
        """The episodes with the most waiting, along their time."""
        longest = max(strip.ticks for strip in group.strips)
        return [self._strip(group.map, strip, longest) for strip in group.longest_waits(STRIPS)]

    def link(self, episode_id: str, tick: int) -> str:
        """The replay at a tick."""
        return f"{self.server.rstrip('/')}/replay/{quote(episode_id, safe='')}#tick={tick}"

    def _chart(self, name: str) -> MeasureChart:
        say, measure, places = (
            self.words.say,
            MEASURES[name],
            {pair: place for place, pair in enumerate(self.tally.populations)},
        )
        factor = 100.0 if measure.unit == "%" else 1.0
        rows: list[tuple[str, list[svg.Dot]]] = []
        for spec, groups in self.tally.by_map():
            row = []
            for group in groups:
                if (found := group.estimate(name)) is not None:
                    blue, red = map(self.name, group.population)
                    value = in_words(found, name, self.words)
                    title = say("report.chart.dot", blue=blue, red=red, value=value, n=found.n)
                    half = factor * (found.stderr or 0.0)
                    row.append(svg.Dot(places[group.population], factor * found.mean, half, title))
            rows.append((self.title(spec), row))
        low, high = measure.scale or _range([dot for _, row in rows for dot in row])
        title = say("report.chart", measure=measure.name(self.words))
        return MeasureChart(measure, svg.dots(rows, low, high, title, self.words.decimal))

    def _strip(self, spec: MapSpec, strip: Strip, longest: int) -> Markup:
        segments = [
            svg.Segment(
                seat=wait.seat,
                start=wait.start / strip.ticks,
                end=wait.end / strip.ticks,
                href=self.link(strip.id, wait.start),
                title=self._waited(spec, wait),
            )
            for wait in strip.waits
        ]
        total = sum(wait.seconds for wait in strip.waits)
        say = self.words.say
        letters = (say("seat.blue.letter"), say("seat.red.letter"))
        return svg.strip(segments, strip.ticks / longest, say("report.strip", id=strip.id, seconds=total), letters)

    def _waited(self, spec: MapSpec, wait: Wait) -> str:
        say = self.words.say
        return say(
            "report.waited",
            seat=say(f"seat.{SEAT_COLOURS[wait.seat]}"),
            item=self.words.item(spec.items[wait.item]) if wait.item < len(spec.items) else say("item.unknown"),
            seconds=wait.seconds,
            start=wait.start * TICK_SECONDS,
        )


def _range(dots: Sequence[svg.Dot]) -> tuple[float, float]:
    """From 0, or below where something is, to the largest end of an interval."""
    low = min((dot.mean - dot.half for dot in dots), default=0.0)
    high = max((dot.mean + dot.half for dot in dots), default=1.0)
    return min(low, 0.0), max(high, 1.0)
