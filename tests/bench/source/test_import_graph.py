from bench.source.import_graph import import_circles, import_graph


def test_a_circle_through_several_modules_is_found_once_and_what_leads_to_it_is_no_part_of_it() -> None:
    graph = {
        "start": frozenset({"a"}),
        "a": frozenset({"b", "end"}),
        "b": frozenset({"c"}),
        "c": frozenset({"a"}),
        "end": frozenset[str](),
    }
    assert import_circles(graph) == [["a", "b", "c"]]


def test_an_import_inside_a_function_counts() -> None:
    """`agents.catalogue` imports the delayed agent only when one is asked for."""
    assert "movingout.agents.baseline.delayed_agent" in import_graph()["movingout.agents.catalogue"]
