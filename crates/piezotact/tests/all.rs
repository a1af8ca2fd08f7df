//! Every test of the science, in one program: it is linked once and runs on all cores.

mod clocks;
mod conjugate_trap;
mod correct;
mod correct_parts;
mod coverage;
mod discrimination;
mod doubts;
mod golden_values;
mod halves;
mod impact;
mod integrity;
mod known_cuts;
mod manipulate;
mod noise;
mod reference;
mod related;
mod roughness;
mod score;
mod shared_data;
mod strokes;
mod structure;
mod studies;
mod study;
mod touch_golden;
mod transfer;
mod vibrations;
