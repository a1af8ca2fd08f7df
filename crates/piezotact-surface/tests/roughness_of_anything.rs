//! Roughness of any profile and any map: finite parameters, or a sentence that says why there are none.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::surface::HeightMap;
use piezotact_surface::{
    ArealConfig, Cutoff, Form, HeightProfile, ProfileConfig, ProfileFilter, ProfileStandard,
    ShortWaves, areal_roughness, profile_roughness,
};
use proptest::prelude::*;

fn heights() -> impl Strategy<Value = Vec<f64>> {
    let height = prop_oneof![
        4 => -1e-5..1e-5,
        1 => Just(0.0),
        1 => Just(1e-300),
        1 => Just(-1e59),
        1 => Just(f64::MAX),
    ];
    prop_oneof![
        prop::collection::vec(-1e-5..1e-5, 8..300),
        prop::collection::vec(height, 8..60),
        (8..200usize, -1e-3..1e-3).prop_map(|(n, z)| vec![z; n]),
    ]
}

fn profile_configs() -> impl Strategy<Value = ProfileConfig> {
    let length = || prop_oneof![1e-7..1e-3, Just(1e-300), Just(f64::MAX), Just(f64::NAN)];
    (
        prop_oneof![
            Just(ProfileStandard::Iso4287),
            Just(ProfileStandard::Iso21920)
        ],
        prop_oneof![
            Just(Form::Mean),
            Just(Form::Level),
            (0..13usize).prop_map(Form::Polynomial)
        ],
        prop_oneof![Just(ProfileFilter::Gauss), Just(ProfileFilter::None)],
        prop_oneof![
            length().prop_map(Cutoff::Stated),
            Just(Cutoff::Iso4288),
            Just(Cutoff::Iso4288Periodic)
        ],
        prop_oneof![
            Just(ShortWaves::Kept),
            Just(ShortWaves::Iso3274),
            length().prop_map(ShortWaves::Stated)
        ],
    )
        .prop_map(
            |(standard, form, filter, cutoff, short_waves)| ProfileConfig {
                standard,
                form,
                filter,
                cutoff,
                short_waves,
            },
        )
}

fn steps() -> impl Strategy<Value = f64> {
    prop_oneof![
        1e-7..1e-4,
        Just(1e-12),
        Just(1e-300),
        Just(1e300),
        Just(1e-3)
    ]
}

proptest! {
    #[test]
    fn any_profile_gives_finite_parameters_or_a_sentence(
        heights_m in heights(),
        step_m in steps(),
        config in profile_configs(),
    ) {
        let profile = HeightProfile::new(heights_m, step_m).unwrap();
        match profile_roughness(&profile, &config) {
            Ok(r) => {
                let values = [r.ra_m, r.rq_m, r.rz_m, r.rt_m, r.rp_m, r.rv_m, r.rdq];
                let others = [r.rsk, r.rku, r.rsm_m].into_iter().flatten();
                prop_assert!(values.into_iter().chain(others).all(f64::is_finite), "{r:?}");
                prop_assert!(r.ra_m <= r.rq_m * (1.0 + 1e-9));
            }
            Err(error) => prop_assert!(error.to_string().contains("expected")),
        }
    }

    #[test]
    fn any_map_gives_finite_parameters_or_a_sentence(
        heights_m in heights(),
        columns in 2..9usize,
        missing in 2..9usize,
        (step_x_m, step_y_m) in (steps(), steps()),
        degree in 0..6usize,
        filters in prop::option::of((1e-7..1e-4, 1e-6..1e-3)),
    ) {
        let mut heights_m = heights_m;
        heights_m.truncate(heights_m.len() / columns * columns);
        for i in (0..heights_m.len()).filter(|i| (i / columns) % missing == 1) {
            heights_m[i] = f64::NAN;
        }
        let Ok(map) = HeightMap::new(heights_m, columns, step_x_m, step_y_m) else {
            return Ok(());
        };
        let config = ArealConfig {
            form: [Form::Mean, Form::Level].get(degree).copied().unwrap_or(Form::Polynomial(degree)),
            s_nesting_m: filters.map(|f| f.0),
            l_nesting_m: filters.map(|f| f.1),
        };
        match areal_roughness(&map, &config) {
            Ok(r) => {
                let values = [r.sa_m, r.sq_m, r.sz_m, r.sp_m, r.sv_m].into_iter();
                let others = [r.ssk, r.sku, r.sdq, r.sdr, r.sal_m, r.str_ratio].into_iter().flatten();
                prop_assert!(values.chain(others).all(f64::is_finite), "{r:?}");
                prop_assert!(r.str_ratio.is_none_or(|s| (0.0..=1.0).contains(&s)));
            }
            Err(error) => prop_assert!(error.to_string().contains("expected")),
        }
    }
}
