//! Slopes of the errors of encoders against central differences, and their inverse.

use touchcal::robot::{EncoderTerm, encoder_error, measured_position};

#[test]
fn slopes_of_errors_are_those_of_differences() {
    const STEP: f64 = 1e-6;
    for term in EncoderTerm::ALL {
        for k in 0..100 {
            let q = 0.1 * f64::from(k) - 5.0;
            let difference = (term.error(q + STEP) - term.error(q - STEP)) / (2.0 * STEP);
            assert!((term.slope(q) - difference).abs() < 1e-8, "{term:?} at {q}: {} {difference}", term.slope(q));
        }
    }
}

#[test]
fn a_measured_position_is_where_its_error_leads_back_to_the_true_one() {
    let terms = EncoderTerm::ALL.map(|term| (term, 0.1));
    for k in 0..100 {
        let q = 0.1 * f64::from(k) - 5.0;
        let measured = measured_position(&terms, q).expect("an inverse");
        assert!((measured - encoder_error(&terms, measured) - q).abs() < 1e-14, "{q}: {measured}");
        assert!((measured - q).abs() > 1e-4);
    }
    // An encoder that stands still, or turns back, has no inverse.
    assert_eq!(measured_position(&[(EncoderTerm::Sine, 1.0)], 0.0), None);
    assert_eq!(measured_position(&[(EncoderTerm::GearRatio, f64::NAN)], 0.0), None);
}
