"""Building models in Python, with the keys of the model file."""

from __future__ import annotations

from typing import Any, Dict

from .model import Model


class Builder:
    """Model builder; every keyword argument is a key of the model file, with the unit in its name.

    >>> wing = (
    ...     Builder("FoldingWing", gravity_m_s2=[0.0, 0.0, -9.81])
    ...     .section("spar", shape="rectangle", width_m=0.12, height_m=0.004, density_kg_m3=1600.0, youngs_modulus_Pa=60e9, poisson_ratio=0.3)
    ...     .body("inner", length_m=0.4, section="spar", elements=2)
    ...     .body("outer", length_m=0.3, section="spar", elements=2)
    ...     .clamped("mount", "inner")
    ...     .revolute("fold", "outer", parent="inner", axis=[0.0, 1.0, 0.0], start_angle_deg=120.0,
    ...               motor=dict(stiffness_N_m_rad=2.0, damping_N_m_s_rad=0.02), latch=dict(stiffness_ratio=1e4))
    ...     .gauge("root", body="inner", position_m=0.01)
    ...     .build()
    ... )
    >>> wing.variables["fold.external_torque"].unit
    'N.m'
    """

    def __init__(self, name: str, **keys: Any) -> None:
        self.tree: Dict[str, Any] = {"name": name, **keys}
        """Mapping for `Model.from_dict`."""

    def table(self, kind: str, name: str, **keys: Any) -> Builder:
        """Add the table `[kind.name]`."""
        self.tree.setdefault(kind, {})[name] = keys
        return self

    def section(self, name: str, **keys: Any) -> Builder:
        """Add `[section.name]`: shape or stiffness, and inertia."""
        return self.table("section", name, **keys)

    def body(self, name: str, **keys: Any) -> Builder:
        """Add `[body.name]`: length, section, elements."""
        return self.table("body", name, **keys)

    def joint(self, name: str, child: str, *, type: str, parent: str = "root", **keys: Any) -> Builder:
        """Add `[joint.name]` between `parent` and the body `child`."""
        return self.table("joint", name, type=type, parent=parent, child=child, **keys)

    def clamped(self, name: str, child: str, *, parent: str = "root", **keys: Any) -> Builder:
        """Add a clamped joint."""
        return self.joint(name, child, type="clamped", parent=parent, **keys)

    def revolute(self, name: str, child: str, *, parent: str = "root", **keys: Any) -> Builder:
        """Add a revolute joint: `axis`, `start_angle_deg`, `motor`, `latch` and other keys."""
        return self.joint(name, child, type="revolute", parent=parent, **keys)

    def prismatic(self, name: str, child: str, *, parent: str = "root", **keys: Any) -> Builder:
        """Add a prismatic joint."""
        return self.joint(name, child, type="prismatic", parent=parent, **keys)

    def cylindrical(self, name: str, child: str, *, parent: str = "root", **keys: Any) -> Builder:
        """Add a cylindrical joint: the child slides along `axis` and rotates about it, with the tables `translation` and `rotation`."""
        return self.joint(name, child, type="cylindrical", parent=parent, **keys)

    def sliding(self, name: str, child: str, *, parent: str, **keys: Any) -> Builder:
        """Add a sliding joint: the child slides along the axis of the beam `parent`, from `start_position_m` (m).

        With `attitude="hinge"` and an `axis` in the section's frame, or `attitude="ball"`, the child also rotates.
        """
        return self.joint(name, child, type="sliding", parent=parent, **keys)

    def gauge(self, name: str, **keys: Any) -> Builder:
        """Add `[gauge.name]`: body and position."""
        return self.table("gauge", name, **keys)

    def settings(self, table: str, **keys: Any) -> Builder:
        """Add keys to a table without a name: `solver`, `simulation`, `aerodynamics`."""
        self.tree.setdefault(table, {}).update(keys)
        return self

    def build(self) -> Model:
        """Build the model; errors report key, value and allowed values."""
        return Model.from_dict(self.tree, str(self.tree["name"]))
