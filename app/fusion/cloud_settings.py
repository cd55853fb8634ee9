"""Settings of the particle cloud, with where each default comes from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CloudSettings:
    """Of the cloud. Chosen on folds 1-4 of the mall walks, never on fold 0, unless said otherwise.

    particles : 1,000 cost 0.05 m of mean error, 500 another 0.1; 2,000 gain 0.01.
    step_sigma_m, turn_sigma_rad : noise of one step's displacement in each direction, and of its turn.
    turn_unknown_rad : of the turn of a phone without gyroscope.
    scale_sigma, scale_drift : of the logarithm of the step-length scale, at first and per step.
    facing_sigma_rad, astray : of the walking direction about the phone's first heading, and the share of particles that
    do not believe it at all.
    heading_noise_rad : of one heading observation; large, since neighbouring ones err alike.
    bias_reach_m : distance over which the error of WiFi fixes is forgotten.
    elsewhere : share that begins at the other places which the first scan is like.
    blocked, through : factor on the weight of a particle that meets a wall, and share of those that go through it.
    rough_m : by what particles drawn twice are told apart.  renewed : share that each resampling after a fix draws
    anew at the fix, for a cloud that is wrong and sure of it.
    least_effective : share of particles that count below which the cloud is resampled.
    """

    particles: int = 1500
    step_sigma_m: float = 0.2
    turn_sigma_rad: float = 0.015
    turn_unknown_rad: float = 0.4
    scale_sigma: float = 0.1
    scale_drift: float = 0.003
    facing_sigma_rad: float = 0.3
    astray: float = 0.1
    heading_noise_rad: float = 1.0
    bias_reach_m: float = 12.0
    elsewhere: float = 0.1
    blocked: float = 0.5
    through: float = 0.1
    rough_m: float = 0.1
    renewed: float = 0.03
    least_effective: float = 0.5
