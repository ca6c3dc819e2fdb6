"""The chart of docs/twelve-maps.md as an SVG: TCR of each agent beside people never trained with.

Colours follow the reader's light or dark theme; no information is in colour alone.
"""

from collections.abc import Mapping, Sequence
from html import escape

from bench._roster import CONTROL, SCRIPTED
from bench.results.episode_log import Outcome
from bench.results.paired_differences import TARGET_TCR
from movingout.agents.curriculum.roster import BASS
from movingout.world.estimates import Estimate, estimate

WIDTH, LEFT, RIGHT, TOP, PITCH, BAR = 800, 290, 44, 52, 34, 18
NOTES = {SCRIPTED: "the expert; they learned from a variant", CONTROL: "control: these people alone"}
STYLE = (
    "text{font:13px Inter,system-ui,sans-serif;fill:#18212c;font-variant-numeric:tabular-nums}"
    ".second{fill:#566273;font-size:11px}.bar{fill:#9aa5b3}.reference{fill:none;stroke:#9aa5b3;stroke-width:1.5}"
    ".error{stroke:#18212c;stroke-width:1.5}.grid{stroke:#dde2e9}.aim{stroke:#566273;stroke-dasharray:5 4}"
    "@media(prefers-color-scheme:dark){text{fill:#e8ecf1}.second{fill:#9aa7b6}.bar{fill:#6d7a8a}"
    ".reference{stroke:#8b97a6}.error{stroke:#e8ecf1}.grid{stroke:#2c3541}.aim{stroke:#9aa7b6}}"
)


def chart(outcomes: Sequence[Outcome], names: Mapping[str, str]) -> str:
    """TCR of each agent as a bar with its standard error, best first; `names` are shown below the ids."""
    by_agent = {agent: estimate([one.tcr for one in outcomes if one.run.agent == agent]) for agent in _agents(outcomes)}
    scores = {agent: found for agent, found in by_agent.items() if found is not None}
    ranked = sorted(scores, key=lambda agent: -scores[agent].mean)
    bottom = TOP + PITCH * len(ranked)
    rows = [_row(TOP + PITCH * place, agent, names.get(agent, ""), scores[agent]) for place, agent in enumerate(ranked)]
    maps = len({one.run.map for one in outcomes})
    title = f"TCR with people of C, never trained with; bars: mean over {maps} maps, lines: standard error"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {bottom + 20}" role="img">'
        f"<title>{title}</title><style>{STYLE}</style>"
        f'<text x="0" y="16">{title}</text>{_scale(bottom)}{"".join(rows)}</svg>\n'
    )


def _agents(outcomes: Sequence[Outcome]) -> list[str]:
    return list(dict.fromkeys(one.run.agent for one in outcomes))


def _x(score: float) -> float:
    return LEFT + score * (WIDTH - LEFT - RIGHT)


def _scale(bottom: float) -> str:
    lines = [
        f'<line class="grid" x1="{_x(tick):.1f}" x2="{_x(tick):.1f}" y1="{TOP - 6}" y2="{bottom}"/>'
        f'<text class="second" x="{_x(tick):.1f}" y="{TOP - 12}" text-anchor="middle">{tick:g}</text>'
        for tick in (0.0, 0.25, 0.5, 0.75, 1.0)
    ]
    aim, words = _x(TARGET_TCR), f"aim of {BASS}: {TARGET_TCR:g}"
    lines.append(
        f'<line class="aim" x1="{aim:.1f}" x2="{aim:.1f}" y1="{TOP - 6}" y2="{bottom}"/>'
        f'<text class="second" x="{aim:.1f}" y="{bottom + 13}" text-anchor="middle">{words}</text>'
    )
    return "".join(lines)


def _row(top: float, agent: str, name: str, found: Estimate) -> str:
    """One agent: names, bar, error and value; the expert and the control are outlined."""
    middle, kind = top + BAR / 2, "reference" if agent in NOTES else "bar"
    mean, error = found.mean, found.stderr or 0.0
    low, high = _x(max(mean - error, 0.0)), _x(min(mean + error, 1.0))
    return (
        f'<text x="0" y="{middle - 1}">{escape(agent)}</text>'
        f'<text class="second" x="0" y="{middle + 13}">{escape(NOTES.get(agent, name))}</text>'
        f'<rect class="{kind}" x="{LEFT}" y="{top}" width="{_x(mean) - LEFT:.1f}" height="{BAR}" rx="3"/>'
        f'<line class="error" x1="{low:.1f}" x2="{high:.1f}" y1="{middle}" y2="{middle}"/>'
        f'<text x="{high + 6:.1f}" y="{middle + 4}">{mean:.2f}</text>'
    )
