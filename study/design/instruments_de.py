"""The ready-made questionnaires in German. The English originals are in `instruments` and `questionnaire`."""

from collections.abc import Mapping
from typing import Final

from movingout.study.design.instrument_text import InstrumentText, ItemText

_SEHR = ("Sehr gering", "Sehr hoch")

_PAPER: Final = InstrumentText(
    title="Über Ihren Partner",
    items={
        "teamwork": ItemText("Der andere Agent und ich haben zusammen auf ein Ziel hingearbeitet."),
        "humanlike": ItemText("Der andere Agent hat sich menschenähnlich verhalten."),
        "reasonable": ItemText("Der andere Agent hat während des ganzen Spiels immer vernünftig gehandelt."),
        "follow": ItemText("Der andere Agent hat sich bei Entscheidungen nach mir gerichtet."),
        "physics": ItemText(
            "Der andere Agent versteht, wie er mit mir zusammenarbeiten muss, wenn Gegenstände unterschiedliche "
            "physikalische Eigenschaften haben."
        ),
        "helpfulness": ItemText(
            "Der andere Agent versteht, was ich vorhabe, und hilft mir von sich aus, wenn ich Unterstützung brauche."
        ),
        "collision": ItemText(
            "Wenn sich unsere Wege kreuzen, können der andere Agent und ich uns gut abstimmen, um Zusammenstöße zu "
            "vermeiden."
        ),
        "alignment": ItemText(
            "Wenn wir große Gegenstände gemeinsam bewegen, stimmen unsere Zielrichtungen gut überein."
        ),
        "future": ItemText(
            "Ich würde auch bei künftigen Aufgaben von Moving Out gern mit dem anderen Agenten zusammenarbeiten."
        ),
        "comment": ItemText("Was möchten Sie sonst noch über das Spielen mit dem anderen Agenten sagen?"),
    },
)

TEXTS: Final[Mapping[str, InstrumentText]] = {
    "movingout-paper-nine": _PAPER,
    "movingout-paper-eight": _PAPER,
    "nasa-tlx": InstrumentText(
        title="Wie anspruchsvoll es war",
        items={
            "mental": ItemText("Wie geistig anspruchsvoll war die Aufgabe?", ends=_SEHR),
            "physical": ItemText("Wie körperlich anspruchsvoll war die Aufgabe?", ends=_SEHR),
            "temporal": ItemText("Wie hektisch oder gehetzt war das Tempo der Aufgabe?", ends=_SEHR),
            "performance": ItemText(
                "Wie erfolgreich haben Sie das geschafft, was von Ihnen verlangt wurde?",
                ends=("Perfekt", "Misserfolg"),
            ),
            "effort": ItemText("Wie sehr mussten Sie sich anstrengen, um Ihre Leistung zu erreichen?", ends=_SEHR),
            "frustration": ItemText(
                "Wie verunsichert, entmutigt, gereizt, gestresst und verärgert waren Sie?", ends=_SEHR
            ),
        },
    ),
    "demographics": InstrumentText(
        title="Über Sie",
        items={
            "age": ItemText("Wie alt sind Sie?", ("18–24", "25–34", "35–44", "45–54", "55–64", "65 oder älter")),
            "gender": ItemText("Welches Geschlecht haben Sie?", ("Frau", "Mann", "Nichtbinär", "Ein anderes")),
            "hand": ItemText("Mit welcher Hand schreiben Sie?", ("Links", "Rechts", "Mit beiden gleich")),
            "colour_vision": ItemText("Fällt es Ihnen schwer, Farben zu unterscheiden?", ("Nein", "Ja")),
            "gaming": ItemText(
                "Wie viele Stunden pro Woche spielen Sie Videospiele?", ("Keine", "Bis zu 2", "3 bis 7", "8 oder mehr")
            ),
            "gamepad": ItemText("Wie oft haben Sie schon ein Gamepad benutzt?", ("Nie", "Ein paarmal", "Oft")),
            "played_before": ItemText("Haben Sie Moving Out schon einmal gespielt?", ("Nein", "Ja")),
        },
    ),
}
