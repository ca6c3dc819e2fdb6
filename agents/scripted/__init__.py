"""The scripted partner."""

from agents.scripted.agent import ScriptedAgent

__all__ = ["ScriptedAgent"]
