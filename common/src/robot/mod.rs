//! The Barrett WAM 7-DOF and BarrettHand BH8-280: tables from the URDF, kinematics, dynamics.
