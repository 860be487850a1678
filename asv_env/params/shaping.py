"""Vessels whose outline is given among the options of an environment."""

from collections.abc import Mapping
from typing import Any

from asv_env import polygons
from asv_env.checks import choice, plain
from asv_env.params.hull_params import VesselParams
from asv_env.params.outlines import SHAPES, Outline
from asv_env.params.ranges import MASS
from asv_env.params.scaling import scaled

Layer = Mapping[str, Any]  #: sections of parameters, or their fields that differ, by name


def given_outline(layers: tuple[Layer, ...]) -> tuple[Any, tuple[Layer, ...]]:
    """Returns the vessel's outline, or None, and the layers without it and what it replaces.

    The last one counts, and replaces extents and whole vessels in the layers before.

    Raises:
        ValueError: a length or a width is given beside an outline.
    """
    outline: Any = None
    rest: list[Layer] = []
    for layer in layers:
        hull = layer.get("vessel", {})
        if not isinstance(hull, Mapping):  # a whole vessel
            outline = None
            rest.append(layer)
            continue
        if hull.get("outline") is not None:
            outline = hull["outline"]
            rest = [_without(each, "length", "width") for each in rest]
        extents = sorted({"length", "width"} & hull.keys())
        if outline is not None and extents:
            raise ValueError(
                f"vessel: {' and '.join(extents)} beside an outline, whose extents they are; "
                "leave them out, or make the outline larger"
            )
        rest.append(_without(layer, "outline"))
    return outline, tuple(rest)


def _without(layer: Layer, *names: str) -> Layer:
    """Returns a layer without some fields of the vessel; a whole vessel goes."""
    if "vessel" not in layer:
        return layer
    hull = layer["vessel"]
    kept = {} if not isinstance(hull, Mapping) else {n: hull[n] for n in hull if n not in names}
    return {**layer, "vessel": kept}


def shaped(outline: Any, needed: float, scale: float, layers: tuple[Layer, ...]) -> VesselParams:
    """Returns the vessel of an outline, whose coefficients are derived at the nominal scale.

    Args:
        outline: corners, m, or a name of ``SHAPES``, whose size is that of the world.
        needed: least length of a named hull, m.
        scale: how many times longer the world is than the nominal one.
        layers: what is given of the vessel; the draft follows from its mass.
    """
    if isinstance(plain(outline), str):
        corners = SHAPES[choice("outline", outline, SHAPES)]
        left, right, _, _ = polygons.extents(corners)
        factor = max(1.0, needed / (scale * (right - left)))
    else:
        corners, factor = Outline().checked("VesselParams.outline", outline), 1.0 / scale
    masses = [layer["vessel"]["mass"] for layer in layers if "mass" in layer.get("vessel", {})]
    mass = MASS.checked("VesselParams.mass", masses[-1]) / scale**3 if masses else None
    nominal = [(factor * x, factor * y) for x, y in corners]
    return scaled(VesselParams.shaped(nominal, mass), scale)
