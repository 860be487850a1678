"""All artefacts, in the order in which they are made."""

from collections.abc import Collection
from pathlib import Path

from baselines.reproduce import (
    claims,
    fig1_2_definitions,
    fig3_4_approach,
    fig5_paths,
    fig6_9_states,
    fig6_arrival,
    fig10_trials,
    plane,
    planner_comparison,
    reach,
    single_runs,
)
from baselines.reproduce.artefact import Artefact, Figure, Study, Table

GEOMETRY = "equations alone, nothing is simulated"
MODEL = "the kinematic model of Eq. (8), without hulls and water"
SIMULATION = "simulation of hulls, water and contact"
BOTH = f"{SIMULATION}; next to it the paper's own numbers from its tank experiment"
ARTEFACTS: dict[str, Artefact] = {
    "fig1": Figure(fig1_2_definitions.closure, GEOMETRY),
    "fig2": Figure(fig1_2_definitions.quantities, GEOMETRY),
    "fig3": Figure(fig3_4_approach.spiral, GEOMETRY),
    "fig4": Figure(fig3_4_approach.swarm, MODEL),
    "fig5": Figure(fig5_paths.correction, GEOMETRY),
    "feasibility": Figure(fig5_paths.feasibility, GEOMETRY),
    "turns": Table(fig5_paths.first_turns, GEOMETRY),
    "reach": Table(reach.table, GEOMETRY),
    "run6": Study(single_runs.noisy_simulation, SIMULATION),
    "arrivals": Study(fig6_arrival.arrivals, SIMULATION),
    "fig6": Figure(
        fig6_9_states.simulation_states, SIMULATION, ("run6", "arrivals"), fig6_arrival.in_words
    ),
    "run7": Study(single_runs.simulations, SIMULATION),
    "fig7": Figure(fig6_9_states.complete_simulations, SIMULATION, ("run7",)),
    "run8": Study(single_runs.experimental_run, SIMULATION),
    "fig8": Figure(fig6_9_states.experiment_states, SIMULATION, ("run8",)),
    "fig9": Figure(fig6_9_states.complete_experiment, SIMULATION, ("run8",)),
    "trials": Study(fig10_trials.trials, SIMULATION),
    "fig10": Figure(fig10_trials.error_figure, BOTH, ("trials",)),
    "table": Table(fig10_trials.table, BOTH, ("trials",)),
    "plane-study": Study(plane.study, SIMULATION),
    "plane": Table(plane.table, SIMULATION, ("plane-study",)),
    "planners-study": Study(planner_comparison.compare, SIMULATION),
    "planners": Figure(planner_comparison.comparison_figure, SIMULATION, ("planners-study",)),
    "planners-table": Table(planner_comparison.table, SIMULATION, ("planners-study",)),
    "claims-study": Study(claims.study, SIMULATION),
    "claims": Table(claims.table, SIMULATION, ("claims-study",)),
}
INTRODUCTION = """\
G. Sartoretti, S. Shaw and M. A. Hsieh, *Distributed Planar Manipulation in Fluidic Environments*;
figures are numbered as in the paper. Written by `python -m baselines.reproduce`; its options, the
versions of the libraries and the fingerprint of the code are in `record.json`.
"""


def selection(names: Collection[str]) -> dict[str, Artefact]:
    """Returns the artefacts with these names, and before them the studies that they need."""
    wanted = set(names) | {need for name in names for need in ARTEFACTS[name].needs}
    return {name: artefact for name, artefact in ARTEFACTS.items() if name in wanted}


def captions(names: Collection[str], folder: Path) -> str:
    """Returns what figures and tables show and where their numbers come from, as Markdown.

    The studies that captions quote are in the folder.
    """
    parts = ["# The paper's figures and tables, reproduced\n", INTRODUCTION]
    for name, artefact in ARTEFACTS.items():
        if name in names and not isinstance(artefact, Study):
            parts.append(
                f"## {name}\n\n{artefact.shown(name)}\n\n{artefact.full_caption(folder)}\n"
            )
            parts.append(f"Source: {artefact.source}.\n")
    return "\n".join(parts)
