"""The positioning methods that a session may ask for, by id."""

from __future__ import annotations

from app.fusion.adaptive_robust_kf import ADAPTIVE_ROBUST_KF
from app.fusion.dual_ukf import DUAL_UKF
from app.fusion.integrity_ukf import INTEGRITY_UKF
from app.fusion.interface import Method
from app.fusion.surefix import SUREFIX
from app.fusion.trust_chain import TRUST_CHAIN
from app.fusion.two_stage_ekf import TWO_STAGE_EKF

METHODS: dict[str, Method] = {
    method.method: method
    for method in (SUREFIX, INTEGRITY_UKF, TWO_STAGE_EKF, DUAL_UKF, ADAPTIVE_ROBUST_KF, TRUST_CHAIN)
}
