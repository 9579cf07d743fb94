// Lengths of the marks in the picture.
export const kArrow_m_per_N = 0.012; // of the force's arrow
export const kNeedleLength_m = 0.12;
