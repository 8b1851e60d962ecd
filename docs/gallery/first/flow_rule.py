"""
What if joints open as they slide?
==================================

Classical limit analysis lets a sliding joint open by tan φ for each unit of slip. Real joints open less,
or not at all. Here a stone is pulled out from under another one, whose other end rests on a rough
support: what does the assumption cost?
"""

import masonry_opt as mo

FRICTION = 0.1


def pulled_out(dilatancy: float) -> mo.Scene:
    """Stone A under one end of stone B (Gilbert, Casapulla & Ahmed 2006, Fig. 6)."""
    return mo.Scene(
        title="a stone pulled out",
        joints=mo.JointDefaults(friction=FRICTION, dilatancy=dilatancy),
        blocks=[
            mo.Block(name="A", vertices=[(2, 0), (5, 0), (5, 1), (2, 1)], weight=1, live=(1, 0)),
            mo.Block(name="B", vertices=[(0, 1), (3, 1), (3, 2), (0, 2)], weight=1),
            mo.Block(name="floor", vertices=[(2, -1), (9, -1), (9, 0), (2, 0)], fixed=True),
            mo.Block(name="rough", vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], fixed=True),
        ],
        exceptions=[mo.Joint(between=("B", "rough"), friction=float("inf"))],
    )


# %%
# Without dilatancy half of B's weight presses on A: μ on the floor and μ/2 above it, λ = 1.5 μ. The least
# dilatancy lifts B about its support, and friction presses it down: 2.5 μ.
for dilatancy in (0.0, 0.01, 0.05, FRICTION):
    result = mo.solve(pulled_out(dilatancy))
    print(f"tan φ₀ = {dilatancy:.2f}: load factor {result.load_factor:.4f}")
assert abs(result.required() - 2.5 * FRICTION) < 1e-6

# %%
# By Coulomb's law, without dilatancy:
result = mo.solve(pulled_out(0.0))
assert abs(result.required() - 1.5 * FRICTION) < 1e-6
result.plot()
