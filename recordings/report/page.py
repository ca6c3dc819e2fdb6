"""The report as one HTML page: no script, nothing from the network, light and dark as the reader's system is."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from urllib.parse import quote

from movingout.maps.spec import SEAT_COLOURS, MapSpec
from movingout.recordings.report import svg
from movingout.recordings.report.facts import Pair
from movingout.recordings.report.failures import TITLES, Case
from movingout.recordings.report.measures import MEASURES, in_words, with_error
from movingout.recordings.report.method import method
from movingout.recordings.report.tally import Found, Group, Strip, Tally
from movingout.recordings.report.waiting import Wait
from movingout.world.constants import TICK_SECONDS
from movingout.world.metrics import METRICS

MOST_LISTED = 300  # findings per case; the JSON output has all
MOST_ABREAST = 4  # populations of a map in one row
STRIPS = 5  # episodes with the most waiting, per group
_STYLE = Path(__file__).with_name("page.css")


_CHARTED = ("success", *(metric.key for metric in METRICS), "seconds")


@dataclass(frozen=True, slots=True)
class Page:
    """What the page is about and where its links lead."""

    folder: str
    server: str  # base address of a running `movingout play` that has these recordings
    tally: Tally

    def html(self) -> str:
        title = f"Report on {self.folder}"
        sections = [self._head(), self._problems(), *self._results(), *self._failures(), method()]
        body = "\n".join(section for section in sections if section)
        return (
            '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{escape(title)}</title>\n<style>\n{_STYLE.read_text(encoding='utf-8')}</style>\n</head>\n"
            f"<body>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
        )

    # ---- top -----------------------------------------------------------------------------------------------

    def _head(self) -> str:
        tally = self.tally
        days = sorted({tally.first[:10], tally.last[:10]} - {""})
        lead = " · ".join([f"{tally.episodes + tally.broken_off} recordings", *([" to ".join(days)] if days else [])])
        figures = [
            _figure(
                "Everything delivered", in_words(tally.overall("success"), "success"), f"{tally.episodes} episodes"
            ),
            _figure("Task completion rate", in_words(tally.overall("tcr"), "tcr"), "all maps and populations"),
            _figure("Waiting time", in_words(tally.overall("wt_s"), "wt_s"), "both seats together, per episode"),
            _figure("Failure cases found", str(len(tally.found)), f"in {_episodes_with(tally.found)} recordings"),
        ]
        return (
            f'<header><h1>Report on {escape(self.folder)}</h1><p class="quiet">{escape(lead)}</p></header>\n'
            f'<section class="figures" aria-label="At a glance">{"".join(figures)}</section>'
        )

    def _problems(self) -> str:
        tally, lines = self.tally, []
        if tally.broken_off:
            lines.append(f"<p>{tally.broken_off} recordings did not run to their end and enter no mean.</p>")
        if tally.unreadable:
            broken = "".join(f"<li>{escape(one.path.name)}: {escape(one.problem)}</li>" for one in tally.unreadable)
            lines.append(f"<p>{len(tally.unreadable)} files cannot be read:</p><ul>{broken}</ul>")
        return f'<section class="notice" aria-label="Left out">{"".join(lines)}</section>' if lines else ""

    # ---- results -------------------------------------------------------------------------------------------

    def _results(self) -> list[str]:
        if not self.tally.episodes:
            return ['<p class="card">No recording here ran to its end, so there are no results to show.</p>']
        return [
            "<h2>Results by map</h2>",
            self._legend(),
            self._charts(),
            self._table(),
            "<h2>Where, when and with whom</h2>"
            '<p class="quiet small">Heat maps: time spent by blue and red, all episodes of a population together. '
            "Strips: the episodes with the most waiting; a stretch opens the replay where it begins.</p>",
            self._maps(),
        ]

    def _legend(self) -> str:
        keys = "".join(
            f"<li>{svg.legend_mark(place)}{_pair(pair)}</li>" for place, pair in enumerate(self.tally.populations)
        )
        return f'<ul class="legend" aria-label="Populations: blue with red">{keys}</ul>'

    def _charts(self) -> str:
        charts = [self._chart(name) for name in _CHARTED]
        return f'<div class="charts">{"".join(charts)}</div>'

    def _chart(self, name: str) -> str:
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
        title = f"{measure.name} by map, mean and standard error"
        heading = f'<h3>{measure.name} <span class="quiet small">{measure.heading}</span></h3>'
        return f'<figure class="card">{heading}{svg.dots(rows, low, high, title)}</figure>'

    def _table(self) -> str:
        heads = "".join(f'<th scope="col">{measure.heading}</th>' for measure in MEASURES.values())
        rows = [_row(spec, group) for spec, groups in self.tally.by_map() for group in groups]
        return (
            '<div class="card scroll" tabindex="0" role="region" aria-label="Results by map and population"><table>'
            f'<thead><tr><th class="words" scope="col">Map</th><th class="words" scope="col">Blue with red</th>'
            f'<th scope="col">n</th>{heads}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
            '<p class="quiet small">Mean ± standard error over episodes. An episode without a value of a metric '
            "does not enter its mean.</p>"
        )

    def _maps(self) -> str:
        wide = min(max(len(groups) for _, groups in self.tally.by_map()), MOST_ABREAST)
        sections = "".join(self._map(spec, groups) for spec, groups in self.tally.by_map())
        return f'<div class="maps" style="--wide: {wide}">{sections}</div>'

    def _map(self, spec: MapSpec, groups: Sequence[Group]) -> str:
        cards = "".join(self._group(spec, group) for group in groups)
        title = escape(spec.title)
        return f'<section aria-label="{title}"><h3>{title}</h3><div class="groups">{cards}</div></section>'

    def _group(self, spec: MapSpec, group: Group) -> str:
        waiting = group.waiting_over_time()
        parts = [
            f"<h4>{_pair(group.population)}</h4>",
            svg.arena(spec, group.presence, items=group.variants == {spec.variant}),
            f'<p class="small quiet">{group.n} {"episode" if group.n == 1 else "episodes"}</p>',
        ]
        if group.values["ac"]:
            drawn = svg.curves([("", group.consistency_over_time())], "Action consistency over time")
            parts.append(f"<h5>Action consistency over time</h5>{drawn}")
        if waiting.any():
            drawn = svg.curves(
                [("blue", waiting[:, 0]), ("red", waiting[:, 1])], "Share of episodes that wait, over time"
            )
            parts.append(f"<h5>Waiting for help over time</h5>{drawn}")
            longest = max(strip.ticks for strip in group.strips)
            parts += [self._strip(spec, strip, longest) for strip in group.longest_waits(STRIPS)]
        return f'<article class="card group">{"".join(parts)}</article>'

    def _strip(self, spec: MapSpec, strip: Strip, longest: int) -> str:
        segments = [
            svg.Segment(
                wait.seat,
                wait.start / strip.ticks,
                wait.end / strip.ticks,
                self._link(strip.id, wait.start),
                _waited(spec, wait),
            )
            for wait in strip.waits
        ]
        total = sum(wait.seconds for wait in strip.waits)
        return svg.strip(segments, strip.ticks / longest, f"Episode {strip.id}: {total:.1f} s of waiting")

    # ---- failures ------------------------------------------------------------------------------------------

    def _failures(self) -> list[str]:
        if not self.tally.people:
            return []
        return [
            "<h2>Failure cases</h2>"
            '<p class="quiet small">Found by rules in the recorded states (see the end): where to look, not whose '
            f"fault it was. Links open the replay at the tick, on {escape(self.server)}.</p>",
            self._rates(),
            *(self._case(case) for case in TITLES),
        ]

    def _rates(self) -> str:
        heads = "".join(f'<th scope="col">{escape(title)}</th>' for title in TITLES.values())
        rows = "".join(self._rate_row(who) for who in self.tally.people)
        return (
            '<div class="card scroll" tabindex="0" role="region" aria-label="How often each failure was found"><table>'
            f'<thead><tr><th class="words" scope="col">Who</th><th scope="col">seats taken</th>{heads}</tr></thead>'
            f"<tbody>{rows}</tbody></table></div>"
            '<p class="quiet small">Share of the episodes in which this seat had at least one, ± standard error.</p>'
        )

    def _rate_row(self, who: str) -> str:
        rates = {case: self.tally.rate(who, case) for case in TITLES}
        cells = "".join(f"<td>{with_error(rate, MEASURES['success'])}</td>" for rate in rates.values())
        return f'<tr><th scope="row">{escape(who)}</th><td>{self.tally.appearances[who]}</td>{cells}</tr>'

    def _case(self, case: Case) -> str:
        found = [one for one in self.tally.found if one.failure.case == case]
        if not found:
            return ""
        found.sort(key=lambda one: -one.failure.seconds)
        rows = "".join(self._finding(one) for one in found[:MOST_LISTED])
        more = len(found) - MOST_LISTED
        rest = f'<p class="quiet small">{more} shorter ones are in the output of --json.</p>' if more > 0 else ""
        opened = "open" if len(found) <= 12 else ""
        return (
            f'<details class="card" {opened}><summary>{TITLES[case]}: {len(found)}</summary>'
            f'<div class="scroll" tabindex="0" role="region" aria-label="{TITLES[case]}"><table><thead><tr>'
            '<th class="words" scope="col">Map</th><th class="words" scope="col">Who</th>'
            '<th class="words" scope="col">Item</th><th scope="col">From</th><th scope="col">For</th>'
            '<th class="words" scope="col">What</th><th class="words" scope="col">Replay</th></tr></thead>'
            f"<tbody>{rows}</tbody></table></div>{rest}</details>"
        )

    def _finding(self, one: Found) -> str:
        facts, failure = one
        item = facts.map.items[failure.item]
        link = self._link(facts.id, failure.start)
        return (
            f'<tr><th scope="row">{escape(facts.map.title)}</th><td class="words">{_seat(failure.seat, one.who)}</td>'
            f'<td class="words">{item.size} {item.shape}</td><td>{failure.start * TICK_SECONDS:.1f} s</td>'
            f'<td>{failure.seconds:.1f} s</td><td class="words">{escape(failure.detail)}</td>'
            f'<td class="words"><a href="{escape(link)}">tick {failure.start}</a></td></tr>'
        )

    def _link(self, episode_id: str, tick: int) -> str:
        return f"{self.server.rstrip('/')}/replay/{quote(episode_id, safe='')}#tick={tick}"


# ---- small pieces ------------------------------------------------------------------------------------------


def _figure(name: str, value: str, note: str) -> str:
    return (
        f'<div class="card"><span class="quiet small">{name}</span><strong>{value}</strong>'
        f'<span class="quiet small">{note}</span></div>'
    )


def _row(spec: MapSpec, group: Group) -> str:
    cells = "".join(f"<td>{with_error(group.estimate(name), measure)}</td>" for name, measure in MEASURES.items())
    return (
        f'<tr><th scope="row">{escape(spec.title)}</th><td class="words">{_pair(group.population)}</td>'
        f"<td>{group.n}</td>{cells}</tr>"
    )


def _range(dots: Sequence[svg.Dot]) -> tuple[float, float]:
    """From 0, or below where something is, to the largest end of an interval."""
    low = min((dot.mean - dot.half for dot in dots), default=0.0)
    high = max((dot.mean + dot.half for dot in dots), default=1.0)
    return min(low, 0.0), max(high, 1.0)


def _pair(pair: Pair) -> str:
    return " with ".join(_seat(seat, who) for seat, who in enumerate(pair))


def _seat(seat: int, who: str) -> str:
    colour = SEAT_COLOURS[seat]
    return f'<span class="badge {colour}" title="{colour}">{colour[0].upper()}</span>{escape(who)}'


def _waited(spec: MapSpec, wait: Wait) -> str:
    item = spec.items[wait.item] if wait.item < len(spec.items) else None
    what = f"the {item.size} {item.shape}" if item else "an item"
    return (
        f"{SEAT_COLOURS[wait.seat]} held {what} alone for {wait.seconds:.1f} s, from {wait.start * TICK_SECONDS:.1f} s"
    )


def _episodes_with(found: Sequence[Found]) -> int:
    return len({one.facts.id for one in found})
