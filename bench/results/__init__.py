"""How docs/twelve-maps.md is made: the log of evaluation episodes, tables, the chart and the page."""
