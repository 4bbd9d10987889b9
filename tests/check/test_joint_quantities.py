# ruff: noqa: E501  (tables of edits, one a line)
"""The polynomials of a joint are those of its loop: compared with the transfer functions, in fractions, at real s."""

from __future__ import annotations

import itertools
from fractions import Fraction
from typing import Any

import pytest
from certificate_builder import data, seal, spec
from claim_floats import Json

from robimp.synthesis.check.joint import Joint, nominal, ranges, stiffness, validate
from robimp.synthesis.check.outcome import CheckError
from robimp.synthesis.check.polynomials import ONE, ZERO, Poly, X
from robimp.synthesis.check.positivity import counterexample
from robimp.synthesis.check.reader import read

F = Fraction
PLACES = [F(1, 2), F(2), F(7, 3)]  # real s
LOAD: Json = {"inertia": "2", "damping": "3", "stiffness": "5"}
DESIRED: Json = {"inertia": "7", "damping": "11", "stiffness": "13"}
LOOP: Json = {"kp": "17", "kd": "19", "derivative_corner": "23", "feedforward": "29"}
MOTOR: Json = {"motor_inertia": "31", "motor_damping": "37", "spring_stiffness": "41"}
TRANSFER: Json = {"numerator": ["2", "3"], "denominator": ["1", "4", "5"]}
ACTUATORS: dict[str, Json] = {
    "ideal": {"type": "ideal"},
    "series-elastic": {"type": "series-elastic", **MOTOR, "torque_loop": LOOP},
    "two-port": {
        "type": "two-port",
        "transfer": TRANSFER,
        "impedance": {"numerator": ["6", "7", "0"], "denominator": ["1", "8", "9"]},
    },
    "two-port over one denominator": {
        "type": "two-port",
        "transfer": TRANSFER,
        "impedance": {"numerator": ["6", "7", "0"], "denominator": ["1", "4", "5"]},
    },
}
FILTERS: dict[str, Json] = {
    "none": None,
    "all": {"force": "43", "position": "47", "derivative": "53"},
    "as the force": {"force": "43", "position": None, "derivative": None},
    "no position": {"force": "43", "position": "none", "derivative": "53"},
}
FEEDBACK: Json = {"type": "dynamic-feedback", "C": {"numerator": ["2", "9"], "denominator": ["3", "1", "4"]}}


def read_of(given: Json = FEEDBACK, asked: Json = None, **sections: Any) -> Json:
    """A certificate as it is read, without claims: the controller, what the specification says of it, and the rest."""
    nothing = {"eq9": None, "eq12": None, "eq18": None, "peak": None, "friction": "report"}
    plain = {"plant": LOAD, "impedance": DESIRED, "uncertainty": {"box": None}, "constraints": nothing}
    body = {
        "robimp_certificate": 1,
        "spec": spec(**{**plain, **sections}, controller={"type": given["type"], **(asked or {})}),
        "controller": given,
        "bandwidth": {"proven": "1", "refuted_at": None, "bound": None},
        "claims": [],
        "assumptions": [],
        "not_claimed": [],
        "producer": {},
    }
    return read(data(seal(body)))


def joint(filters: Json = None, point: Any = None, **sections: Any) -> Joint:
    found = read_of(asked={"filters": filters}, **sections)
    return Joint(found["spec"], found["controller"], point or {})


def value(p: Poly, s: F) -> F:
    return F(sum(a * s**k for k, a in enumerate(p.c)), p.d)


def at(section: Json, s: F) -> F:
    def polynomial(key: str) -> F:
        return sum((F(c) * s**k for k, c in enumerate(reversed(section[key]))), F(0))

    return polynomial("numerator") / polynomial("denominator")


def quadratic(section: Json, s: F) -> F:
    I, B, K = (F(v) for v in section.values())  # noqa: E741
    return I * s * s + B * s + K


class Loop:
    """Transfer functions of the loop at real s, as the documentation gives them."""

    def __init__(self, actuator: Json, filters: Json, s: F, load: Json = LOAD, desired: Json = DESIRED) -> None:
        def lag(key: str) -> F:
            corner = (filters or {}).get(key)
            return F(1) if corner is None else 1 / (1 + s / F(corner))

        force, derivative = lag("force"), lag("derivative")
        position = (filters or {}).get("position")
        angle = force if position is None else F(1) if position == "none" else lag("position")
        self.g, self.m, g_hat = quadratic(load, s), quadratic(desired, s), quadratic(LOAD, s)
        self.H, self.Z_a = self.actuator(actuator, s)
        C = at(FEEDBACK["C"], s)
        self.command = C * force / (1 + self.H * C * force)
        self.rest = 1 / (1 + self.H * C * force)  # 1 − Q̃
        self.rest_i = 1 / (1 + C * force)  # 1 − Q_i
        self.U = (1 - self.rest_i) * angle / force * self.m - self.rest_i * derivative * (g_hat - self.m)
        Z_0 = self.g + self.Z_a - self.H * derivative * (g_hat - self.m)
        self.Z = (1 - self.rest) * angle / force * self.m + self.rest * Z_0

    def actuator(self, given: Json, s: F) -> tuple[F, F]:
        if given["type"] == "ideal":
            return F(1), F(0)
        if given["type"] == "two-port":
            return at(given["transfer"], s), at(given["impedance"], s)
        loop = {key: F(v) for key, v in given["torque_loop"].items()}
        C_t = loop["kp"] + loop["kd"] * s / (1 + s / loop["derivative_corner"])
        J, b, K_sp = (F(given[key]) for key in MOTOR)
        below = J * s * s + b * s + K_sp * (1 + C_t)
        return K_sp * (C_t + loop["feedforward"]) / below, K_sp * (J * s * s + b * s) / below


@pytest.mark.parametrize("filters", FILTERS)
@pytest.mark.parametrize("actuator", ACTUATORS)
def test_the_polynomials_are_those_of_the_loop(actuator: str, filters: str) -> None:
    j = joint(FILTERS[filters], actuator=ACTUATORS[actuator])
    for s in PLACES:
        loop, locked = Loop(ACTUATORS[actuator], FILTERS[filters], s), value(j.locked, s)
        without, with_hold = (value(part, s) for part in j.loop("stability-free"))
        assert (value(j.nominal, s), value(j.load, s), value(j.desired, s)) == (loop.g, loop.g, loop.m)
        assert (value(j.n_H, s), value(j.n_Z, s)) == (loop.H * value(j.d, s), loop.Z_a * value(j.d, s))
        assert value(j.E, s) == loop.rest * locked and value(j.rest, s) == (1 - loop.rest) * locked
        assert value(j.command, s) == loop.command * locked
        assert value(j.E_i, s) == loop.rest_i * value(j.D_i, s) and value(j.U_n, s) == loop.U * value(j.D_i, s)
        assert value(j.free(j.nominal), s) == loop.Z * locked == without + with_hold
        assert with_hold == loop.H * loop.U * value(j.d, s) * value(j.D_i, s)
        assert without == loop.rest_i * (loop.g + loop.Z_a) * value(j.d, s) * value(j.D_i, s)
        assert value(j.carried, s) + value(j.driven, s) == value(j.M, s)
        assert sum(value(part, s) for part in j.loop("stability-locked")) == locked


ORDERS = {  # states of the loop against a wall: of the actuator, the controller, and the filters
    ("ideal", "none"): 2,
    ("ideal", "all"): 5,
    ("ideal", "no position"): 4,
    ("series-elastic", "none"): 5,
    ("two-port", "none"): 6,
    ("two-port over one denominator", "none"): 4,
}


@pytest.mark.parametrize(("actuator", "filters"), ORDERS)
def test_nothing_is_added_to_the_states_of_the_loop(actuator: str, filters: str) -> None:
    j = joint(FILTERS[filters], actuator=ACTUATORS[actuator])
    assert len(j.locked.c) - 1 == ORDERS[actuator, filters]


def test_parameters_at_a_point_take_the_place_of_nominal_ones() -> None:
    """The nominal load is what the controller knows, whatever the load."""
    load, desired, motor = (
        {key: str(F(v) + k) for k, (key, v) in enumerate(part.items(), 1)} for part in (LOAD, DESIRED, MOTOR)
    )
    given = {"plant": load, "impedance": desired, "actuator": motor}
    point = {(section, key): F(v) for section, part in given.items() for key, v in part.items()}
    j = joint(actuator=ACTUATORS["series-elastic"], point=point)
    for s in PLACES:
        loop = Loop({**ACTUATORS["series-elastic"], **motor}, None, s, load, desired)
        assert value(j.free(j.load), s) == loop.Z * value(j.locked, s)
        assert value(j.nominal, s) == quadratic(LOAD, s) and value(j.load, s) == loop.g
        assert sum(value(part, s) for part in j.loop("stability-free")) == loop.Z * value(j.locked, s)
        assert sum(value(part, s) for part in j.loop("stability-free", j.nominal)) == value(j.free(j.nominal), s)


BOX: Json = {"inertia": ["1", "4"], "damping": ["2", "4"], "stiffness": ["3", "6"]}


def g(*load: int) -> Poly:
    return stiffness([F(v) for v in load])


def test_the_corners_of_the_rectangle_that_the_load_moves_in() -> None:
    j = joint(uncertainty={"box": BOX})
    assert j.corners == [g(4, 2, 3), g(1, 2, 6), g(4, 4, 3), g(1, 4, 6)]
    assert j.edge == [g(4, 2, 3), g(1, 2, 6)]  # the least damping
    free = joint(uncertainty={"box": {**BOX, "stiffness": ["0", "0"]}}, plant={**LOAD, "stiffness": "0"})
    assert free.corners == [g(4, 2, 0), g(1, 2, 0), g(4, 4, 0), g(1, 4, 0)] and free.edge == []
    point = joint(uncertainty={"box": {key: [v, v] for key, v in LOAD.items()}})
    assert point.corners == [g(2, 3, 5)] and point.edge == [g(2, 3, 5), g(2, 3, 5)]
    assert joint().corners == [g(2, 3, 5)] and joint().edge == []


def test_the_loads_that_decide() -> None:
    j, one = joint(uncertainty={"box": BOX}), g(3, 3, 4)
    assert j.loads(None) == j.corners and j.loads(one) == [one]
    x = F(5, 7)

    def of(load: Poly) -> tuple[F, F]:
        I, B, K = (F(v) for v in reversed(load.c))  # noqa: E741
        return (5 - K - (2 - I) * x) ** 2 + (3 - B) ** 2 * x, (K - I * x) ** 2 + B**2 * x

    for given, loads in ((None, j.corners), (one, [one])):
        assert [(value(gap, x), value(size, x)) for gap, size in j.ratios(given)] == [of(load) for load in loads]
        assert j.ratios(given, edge=True) == j.ratios(given)  # no place on the edge is a parameter here


def test_on_an_edge_with_a_parameter_its_place_is_one_more_load() -> None:
    j = joint(uncertainty={"box": BOX})
    j.place.append(g(2, 2, 4))
    assert len(j.ratios(None)) == 4 and len(j.ratios(g(1, 2, 3), edge=True)) == 1
    assert j.ratios(None, edge=True) == [*j.ratios(None), *j.ratios(g(2, 2, 4))]


def test_the_radius_of_the_disc() -> None:
    weight = {"numerator": ["2", "3"], "denominator": ["5", "7"]}
    gap, size = joint(uncertainty={"box": None, "weight": weight}).disc
    assert (value(gap, F(1)), value(size, F(1))) == (4 + 9, 25 + 49)
    assert joint().disc == (ZERO, ONE)


@pytest.mark.parametrize("w", [F(0), F(1, 9), F(1, 4), F(4, 9)])
def test_three_roots_of_two_polynomials_and_a_weight(w: F) -> None:
    """`√w (√a + √b + √c) < √(c size)`, for squares of rational numbers, where both sides are known."""
    j, sides = joint(), [F(0), F(1, 2), F(1), F(3)]
    for a, b, c, size in itertools.product(sides, sides, sides[1:], [F(1), F(2)]):
        parts = j.weighed(*(Poly.of(v) for v in (w, a * a, b * b, c * c, size * size)))
        root = {F(0): F(0), F(1, 9): F(1, 3), F(1, 4): F(1, 2), F(4, 9): F(2, 3)}[w]
        holds = all(counterexample(part, (1, 1), (1, 1), float("inf")) is None for part in parts)
        assert holds == (root * (a + b + c) < c * size), (a, b, c, size)


def test_where_all_of_them_vanish_leading_coefficients_are_compared() -> None:
    parts = joint().weighed(ZERO, ZERO, ZERO, X, ONE)
    assert all(counterexample(part, (0, 1), (1, 0), float("inf")) is None for part in parts)


def test_ranges_are_scaled_about_the_nominal() -> None:
    s = read_of(
        uncertainty={"box": BOX, "actuator": {"motor_inertia": ["30", "33"], "spring_stiffness": ["41", "41"]}},
        impedance={**DESIRED, "damping": ["10", "16"], "stiffness": ["13", "13"]},
        actuator=ACTUATORS["series-elastic"],
    )["spec"]
    plant = {("plant", "inertia"): (1, 4), ("plant", "damping"): (2, 4), ("plant", "stiffness"): (3, 6)}
    assert ranges(s, ["plant"]) == plant
    others = {("impedance", "damping"): (10, 16), ("actuator", "motor_inertia"): (30, 33)}
    assert ranges(s, ["plant", "impedance", "actuator"]) == plant | others
    assert ranges(s, ["impedance", "actuator"], F(2)) == {
        ("impedance", "damping"): (7, 19),
        ("actuator", "motor_inertia"): (29, 35),
    }
    assert ranges(s, ["plant"], F(1, 2))["plant", "inertia"] == (F(3, 2), 3)
    assert nominal(s, "impedance", "damping") == 13 and nominal(s, "impedance", "inertia") == 7
    assert ranges(read_of()["spec"], ["plant", "impedance", "actuator"]) == {}


def complaint(*controller: Json, **sections: Any) -> tuple[int, str]:
    """What is wrong with a specification or its controller; 0 and nothing if nothing is."""
    try:
        validate(read_of(*controller, **sections), float("inf"))
    except CheckError as error:
        return error.code, str(error)
    return 0, ""


def port(key: str, *numerator: str) -> Json:
    ratio = {"numerator": list(numerator), "denominator": ["1", "2"]}
    return {"actuator": {**ACTUATORS["two-port"], key: ratio}}


def weight(numerator: list[str], denominator: list[str]) -> Json:
    return {"uncertainty": {"box": None, "weight": {"numerator": numerator, "denominator": denominator}}}


UNUSABLE: dict[str, tuple[Json, str]] = {
    **{
        f"a box {where}": (
            {"uncertainty": {"box": {**BOX, "damping": ends}}},
            "spec.uncertainty.box: does not contain the nominal damping",
        )
        for where, ends in (("above", ["4", "5"]), ("below", ["1", "2"]))
    },
    "a motor elsewhere": (
        {
            "uncertainty": {"box": None, "actuator": {"motor_damping": ["1", "2"]}},
            "actuator": ACTUATORS["series-elastic"],
        },
        "spec.uncertainty.actuator: does not contain the nominal motor_damping",
    ),
    "a motor that is not there": (
        {"uncertainty": {"box": None, "actuator": {"motor_damping": ["1", "2"]}}, "actuator": {"type": "ideal"}},
        "spec.uncertainty.actuator: does not contain the nominal motor_damping",
    ),
    "a transfer that is not proper": (port("transfer", "1", "0", "0"), "spec.actuator.transfer: not proper"),
    "an impedance that is not proper": (port("impedance", "1", "0", "0"), "spec.actuator.impedance: not proper"),
    **{
        name: (weight(*given), "spec.uncertainty.weight: must be stable and proper")
        for name, given in {
            "a weight that is not proper": (["1", "2", "3"], ["1", "4"]),
            "a weight with an integrator": (["1"], ["1", "0"]),
            "an unstable weight": (["1"], ["1", "-1"]),
            "a weight that rings for ever": (["1"], ["1", "0", "1"]),
        }.items()
    },
}
USABLE: dict[str, Json] = {
    "nominal at the lower end": {"uncertainty": {"box": {**BOX, "damping": ["3", "9"]}}},
    "nominal at the upper end": {"uncertainty": {"box": {**BOX, "damping": ["1", "3"]}}},
    "a two-port as fast as its denominator": {**port("transfer", "1", "0"), **port("impedance", "1", "0")},
    "a slow weight": weight(["1"], ["1", "1/1000"]),
    "a weight as fast as its denominator": weight(["1", "0"], ["1", "4"]),
    "a constant weight": weight(["1/2"], ["1"]),
}


@pytest.mark.parametrize("name", UNUSABLE)
def test_a_specification_that_makes_no_sense_is_2(name: str) -> None:
    sections, text = UNUSABLE[name]
    assert complaint(**sections) == (2, text)


@pytest.mark.parametrize("name", USABLE)
def test_a_specification_that_makes_sense(name: str) -> None:
    assert complaint(**USABLE[name]) == (0, "")


def feedback(numerator: list[str], denominator: list[str]) -> Json:
    return {"type": "dynamic-feedback", "C": {"numerator": numerator, "denominator": denominator}}


def observer(Q: tuple[list[str], list[str]], C: tuple[list[str], list[str]]) -> Json:
    Q_, C_ = ({"numerator": n, "denominator": d} for n, d in (Q, C))
    return {"type": "dob", "Q": Q_, "C": C_}


LAG, GIVEN = (["4"], ["1", "5"]), {"coefficients": {"numerator": ["2"], "denominator": ["1", "3"]}}
NOT_C, NOT_GIVEN = "controller.C: is not Q/(1-Q)", "controller.C: is not the one the specification gives"
CONTROLLERS: dict[str, tuple[Json, Json, int, str]] = {  # the one of the certificate, what is asked, the answer
    "Q and its C": (observer(LAG, (["4"], ["1", "1"])), None, 0, ""),
    "C times a factor": (observer(LAG, (["-8"], ["-2", "-2"])), None, 0, ""),
    "Q as fast as its denominator": (observer((["1", "0"], ["2", "1"]), (["1", "0"], ["1", "1"])), None, 0, ""),
    "Q = 0": (observer((["0"], ["1", "5"]), (["0"], ["1", "5"])), None, 0, ""),
    "Q = 2": (observer((["2"], ["1"]), (["2"], ["-1"])), None, 0, ""),
    "Q that is not proper": (observer((["1", "0", "0"], ["1", "5"]), (["1"], ["1"])), None, 2, "controller.Q: must be proper and not 1"),
    "Q = 1": (observer((["1", "5"], ["1", "5"]), (["1"], ["1"])), None, 2, "controller.Q: must be proper and not 1"),
    "C with another numerator": (observer(LAG, (["5"], ["1", "1"])), None, 6, NOT_C),
    "C with another denominator": (observer(LAG, (["4"], ["1", "2"])), None, 6, NOT_C),
    "C with a zero above": (observer(LAG, (["0", "4"], ["1", "1"])), None, 6, NOT_C),
    "C with a zero below": (observer(LAG, (["4"], ["0", "1", "1"])), None, 6, NOT_C),
    "C with a factor cancelled": (observer((["4", "8"], ["1", "7", "10"]), (["4"], ["1", "1"])), None, 6, NOT_C),
    "C with a factor": (observer((["4", "8"], ["1", "7", "10"]), (["4", "8"], ["1", "3", "2"])), None, 0, ""),
    "another type": (feedback(["4"], ["1", "1"]), {"type": "dob"}, 6, "controller.type: is not the specification's"),
    "the one given": (feedback(["2"], ["1", "3"]), GIVEN, 0, ""),
    "the one given, times a factor": (feedback(["-4/3"], ["-2/3", "-2"]), GIVEN, 0, ""),
    "the one given, half of both": (feedback(["1"], ["1/2", "3/2"]), GIVEN, 0, ""),
    "an integrator given": (feedback(["2", "2"], ["2", "0"]), {"coefficients": {"numerator": ["1", "1"], "denominator": ["1", "0"]}}, 0, ""),
    "not the one given": (feedback(["2"], ["1", "4"]), GIVEN, 6, NOT_GIVEN),
    "not the gain given": (feedback(["3"], ["1", "3"]), GIVEN, 6, NOT_GIVEN),
    "not the one given but equal to it": (feedback(["2", "2"], ["1", "4", "3"]), GIVEN, 6, NOT_GIVEN),
    "of the order asked": (feedback(["2"], ["1", "3"]), {"order": 1}, 0, ""),
    "below the order asked": (feedback(["2"], ["1"]), {"order": 1}, 0, ""),
    "above the order asked": (feedback(["2"], ["1", "3"]), {"order": 0}, 6, "controller.C: is above the specification's order"),
    "C as fast as its denominator": (feedback(["2", "1"], ["1", "3"]), None, 0, ""),
    "C that is not proper": (feedback(["1", "2"], ["3"]), {"form": "lead-lag"}, 2, "controller.C: must be proper"),
    "Q(∞) = 1": (observer((["2", "1"], ["2", "3"]), (["2", "1"], ["2"])), None, 2, "controller.C: must be proper"),
    "zeros above the order asked": (feedback(["1", "1", "2"], ["1", "3"]), {"order": 1}, 6, "controller.C: is above the specification's order"),
    "Q above the order asked": (observer(LAG, (["4"], ["1", "1"])), {"order": 0}, 6, "controller.Q: is above the specification's order"),
}  # fmt: skip


@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_controller_is_the_one_the_specification_allows(name: str) -> None:
    given, asked, code, text = CONTROLLERS[name]
    assert complaint(given, asked) == (code, text)


def test_a_weight_of_many_poles_is_looked_at_within_the_time() -> None:
    certificate = read_of(**weight(["1"], ["1", "4", "5", "2"]))
    with pytest.raises(CheckError, match="time limit reached") as stop:
        validate(certificate, 0)
    assert stop.value.code == 5
