//! The sections of the parameter file, number by number. What a number means stands beside it in the file.

use serde::Deserialize;

macro_rules! parameters {
    ($(#[$doc:meta])* $name:ident { $($field:ident : $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name { $(pub $field: $type),* }
    };
}

parameters! {
    /// Section `person`.
    PersonParameters {
        reference_ridge_m: f64, ridge_m: f64, ridge_spread_m: f64, least_ridge_m: f64, most_ridge_m: f64,
        loudness_spread: f64, loudness_spread_by_sample: f64, friction_spread: f64,
    }
}
parameters! {
    /// Section `finger`.
    FingerParameters {
        pulp_stiffness_n_m: f64, pulp_damping_n_s_m: f64, pulp_load_exponent: f64, reference_load_n: f64, least_load_n: f64, phalanx_kg: f64, joint_stiffness_n_m: f64, joint_damping_n_s_m: f64, hand_kg: f64, hand_stiffness_n_m: f64, hand_damping_n_s_m: f64, nail_kg: f64, nail_stiffness_n_m: f64, nail_damping_n_s_m: f64, coupling_loss: f64, coupling_loss_load_n: f64, coupling_loss_spread: f64, coupling_loss_ripple: f64, skin_kg: f64, angle_mass: f64, angle_stiffness: f64, pulp_stiffness_spread: f64, pulp_damping_spread: f64, phalanx_mass_spread: f64, joint_stiffness_spread: f64, joint_damping_spread: f64, hand_mass_spread: f64, nail_stiffness_spread: f64, skin_mass_spread: f64, gain_spread: f64, ripple_db: f64, ripple_octaves: f64, spread_load_exponent: f64,
    }
}
parameters! {
    /// Section `placement`.
    PlacementParameters {
        gain_db: f64, ripple_db: f64,
    }
}
parameters! {
    /// Section `actuator`.
    ActuatorParameters {
        membrane_stiffness_n_m: f64, membrane_damping_n_s_m: f64, membrane_kg: f64, free_m_per_v: f64, low_pass_hz: f64, latency_s: f64,
    }
}
parameters! {
    /// Section `shaker`.
    ShakerParameters {
        moving_mass_kg: f64, suspension_hz: f64, suspension_damping_ratio: f64, gain_m_s2_per_v: f64, most_rms_v: f64, plate_kg: f64, accelerometer_kg: f64, artefact_hz: f64, artefact_zero_damping_ratio: f64, artefact_pole_damping_ratio: f64, force_noise_n: f64, least_drift_n: f64, most_drift_n: f64, drift_s: f64,
    }
}
parameters! {
    /// Section `hand`.
    HandParameters {
        stroke_margin_m: f64, ramp_s: f64, landing_s: f64, take_off_s: f64, lift_s: f64, lift_spread: f64,
        speed_bias: f64, speed_spread_metronome: f64, speed_spread_free: f64, speed_spread_within: f64,
        speed_memory_s: f64, force_bias: f64, force_spread_n: f64, force_memory_s: f64, force_hz: f64, least_force_n: f64,
        transient_least_m_s2: f64, transient_most_m_s2: f64, transient_hz: f64, transient_s: f64,
        gesture_least_m_s2: f64, gesture_most_m_s2: f64, gesture_hz: f64, tremor_hz: f64,
        tremor_m_s2: f64,
        free_speed_m_s: f64, free_speed_spread: f64, least_free_speed_m_s: f64, most_free_speed_m_s: f64,
        free_force_n: f64, free_force_spread: f64, free_force_exponent: f64, circle_m: f64,
        yaw_deg: f64, angle_deg: f64, track_hz: f64, track_noise_m: f64,
    }
}
parameters! {
    /// Section `texture`.
    TextureModel {
        reference_speed_m_s: f64, reference_load_n: f64, speed_exponent: f64, force_exponent: f64,
        rise_hz: f64, fall_hz: f64, shift_exponent: f64, ridge_teeth: Vec<f64>, ridge_width: f64,
        comb_width: f64, comb_decay: f64, comb_teeth: f64, tangential_to_nail: f64,
        direction_level: f64, direction_width: f64, distal_level: f64,
    }
}
parameters! {
    /// Section `friction`.
    FrictionModel {
        load_exponent: f64, falls_over_m_s: f64, static_ratio: f64, fluctuation: f64, fluctuation_m: f64,
        mass_kg: f64,
    }
}
parameters! {
    /// Section `relief`.
    ReliefParameters {
        hurst: f64, correlation_per_grain: f64, skewness: f64, edge_m: f64, resin_roughness_m: f64,
        print_roughness_m: f64,
    }
}
parameters! {
    /// One of the sections `drag`.
    Drag { stiffness_n_m: f64, damping_n_s_m: f64 }
}
parameters! {
    /// The sections `drag`.
    DragParameters { active: Drag, across: Drag, distal: Drag, held: Drag }
}
parameters! {
    /// Section `accelerometer`.
    AccelerometerParameters {
        white_m_s2: f64, flicker_m_s2: f64, flicker_hz: f64, sensitivity_spread: f64, range_m_s2: f64,
    }
}
parameters! {
    /// Section `force_cell`.
    ForceCellParameters { noise_n: f64, crosstalk: f64, drift_n_s: f64, offset_n: f64, range_n: f64 }
}
parameters! {
    /// Section `piezo_cells`.
    PiezoCellParameters { noise_n: f64, crosstalk: f64, discharge_s: f64, range_n: f64 }
}
parameters! {
    /// Section `triboair`.
    TriboAirParameters {
        track_m: f64, acceleration_m_s2: f64, speed_ripple: f64, shortest_plateau_s: f64,
        encoder_step_m: f64, placing_s: f64, waiting_s: f64, return_m_s: f64,
    }
}
parameters! {
    /// Section `output`.
    OutputParameters {
        volts_per_full_scale: f64, corner_hz: f64, noise_db: f64, quadratic: f64,
    }
}
parameters! {
    /// Section `eeg`.
    EegParameters {
        head_m: f64, background: EegBackground, alpha: EegAlpha, desynchronisation: EegDesynchronisation, evoked: EegEvoked,
        eyes: EegEyes, muscle: EegMuscle, line: EegLine, protocol: EegSession,
    }
}
parameters! {
    /// Section `eeg.background`.
    EegBackground {
        rms_v: f64, rms_spread: f64, channel_spread: f64, exponent: f64, knee_hz: f64, correlation_m: f64, own_share: f64,
    }
}
parameters! {
    /// Section `eeg.alpha`.
    EegAlpha {
        frequency_hz: f64, frequency_spread_hz: f64, bandwidth_hz: f64, mu_v: f64, mu_spread: f64, source_m: f64,
        sma_share: f64, occipital_v: f64, occipital_spread: f64,
    }
}
parameters! {
    /// Section `eeg.desynchronisation`.
    EegDesynchronisation {
        control: f64, imagery: f64, natural: f64, person_spread: f64, task_spread: f64, surface_spread: f64, onset_s: f64,
        onset_width_s: f64,
    }
}
parameters! {
    /// Section `eeg.evoked`.
    EegEvoked {
        amplitude_v: f64, amplitude_spread: f64, latency_s: [f64; 3], share: [f64; 3], width_s: [f64; 3], source_m: f64,
        natural_gain: f64, imagery_gain: f64,
    }
}
parameters! {
    /// Section `eeg.eyes`.
    EegEyes {
        blinks_per_min: f64, blink_v: f64, blink_spread: f64, blink_s: f64, reach_m: f64, eog_ratio: f64, movement_v: f64,
        movement_memory_s: f64, movement_share: f64,
    }
}
parameters! {
    /// Section `eeg.muscle`.
    EegMuscle {
        rms_v: f64, reach_m: f64, everywhere: f64, least_hz: f64, most_hz: f64, natural_ratio: f64, planning_s: f64,
    }
}
parameters! {
    /// Section `eeg.line`.
    EegLine { frequency_hz: f64, amplitude_v: f64, amplitude_spread: f64 }
}
parameters! {
    /// Section `eeg.protocol`.
    EegSession { rate_hz: f64, trials_per_surface: f64, rest_s: f64, rest_jitter_s: f64, touch_s: f64 }
}
