"""What a kind of trained agent is: one record, from its options on the command line to the agent that plays."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic

from movingout.agents.base import Agent
from movingout.agents.checkpoint.card import Training
from movingout.agents.checkpoint.checkpoint import Checkpoint
from movingout.agents.training.run import ConfigT, TrainingRun


@dataclass(frozen=True, slots=True)
class Trained:
    """What a training run has made."""

    checkpoint: Checkpoint
    training: Training  # where the weights come from that were trained in this run


@dataclass(frozen=True, slots=True)
class AgentKind(Generic[ConfigT]):
    """Everything that commands, catalogue and server know about a kind. Making a record imports no torch."""

    name: str  # `movingout train NAME`, and `kind` on the card unless `saved_as` says another
    summary: str  # one phrase for --help
    presets: Mapping[str, ConfigT]  # by the word of --preset, `paper` where it gives numbers; fields become options
    add_options: Callable[[argparse.ArgumentParser], None]  # those that are not fields of the configuration
    option_names: tuple[str, ...]  # of these, the ones that a run folder keeps
    train: Callable[[TrainingRun[ConfigT]], Trained]  # trains, exports, writes the checkpoint folder; may import torch
    load: Callable[..., Agent]  # a checkpoint, and the options of an id as keywords (`bass@all:execute=4`)
    saved_as: str = ""  # `kind` on the card where it is that of another: a best response plays as a `dp`
    check: Callable[..., object] | None = None
    """A card, and the options of an id as keywords: raises AgentError for those with which rooms cannot load it, and
    reads no weights. None: any that `load` takes by name."""
    from_recordings: bool = True  # else it learns from its own play, and options about recordings are not shown
    example: str = "data/demos"  # what `movingout train NAME` needs beside --id, as --help shows it
    offered: bool = True  # to people who choose a partner; the others are for training and measuring
