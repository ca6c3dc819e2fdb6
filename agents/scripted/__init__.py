"""The scripted partner."""

from movingout.agents.scripted.agent import ScriptedAgent

__all__ = ["ScriptedAgent"]
