"""A specification to start from: every key explained, every number to be replaced by the joint's own."""

from __future__ import annotations

from typing import Literal

Kind = Literal["series-elastic", "ideal"]

_ACTUATOR: dict[Kind, str] = {
    "series-elastic": """\
actuator:                          # motor, spring and the inner torque loop τ_m = λτ_d + C_t(τ_d − τ_sea)
  type: series-elastic
  motor_inertia: 0.01              # J, reflected to the output
  motor_damping: 0.05              # b_m
  spring_stiffness: 4.8            # K_sp
  torque_loop: {kp: 10, kd: 0.25, derivative_corner: 1000, feedforward: 1}   # C_t = kp + kd s/(1 + s/corner), λ
""",
    "ideal": """\
actuator: {type: ideal}            # torque follows its command at once; `series-elastic` and `two-port` model a drive
""",
}
_EQ18: dict[Kind, str] = {
    "series-elastic": "  eq18: {form: half-plane, coupling: physical}   # (18): the same with the drive's dynamics\n",
    "ideal": "",
}


def template(name: str, kind: Kind) -> str:
    """A commented specification, YAML, of a joint with this kind of actuator."""
    return f"""\
# A specification for `robimp synth`. Every number is only an example: put your joint's own. A bare number is SI (N·m,
# rad, s), a frequency rad/s; with a unit it is text: "300 g·m²", "±20 %", "40 Hz". `robimp schema` lists every key.
robimp: 1
name: {name}
motion: rotary                     # or linear

plant:                             # nominal load I θ'' + B θ' + K θ, as the actuator's output sees it
  inertia: 0.03
  damping: 0.2
  stiffness: 0

uncertainty:                       # how wrong that may be; nothing has a default
  box: {{inertia: ±20 %, damping: ±40 %, stiffness: [0, 0]}}

{_ACTUATOR[kind]}
impedance:                         # what the port should feel like; an interval asks for one controller for all of it
  inertia: nominal                 # the load's own inertia is not shaped
  damping: 0.35
  stiffness: 1.25

controller: {{type: dob, order: 2}} # of the disturbance observer's Q: 2 is fast to find, 4 or 6 reach further

objective:
  maximize: bandwidth              # the largest ω_B up to which
  attenuation: 0.5                 # a disturbance is reduced to this share

constraints:
  eq9: {{}}                          # (9): stable for every load
  eq12: {{form: structured}}         # (12): passive for every load, so stable against every passive environment
{_EQ18[kind]}  peak: 2.0                        # no disturbance is amplified by more

sampling: {{rate: 1 kHz, delay: 1 ms}}    # the drive's zero-order hold and computation delay are part of what is proven
"""
