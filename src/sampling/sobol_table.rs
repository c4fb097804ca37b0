//! Generator matrices of Sobol' sequences from Joe & Kuo's direction numbers (2008, "Constructing Sobol Sequences with
//! Better Two-Dimensional Projections", new-joe-kuo-6.21201).

pub const DIMENSIONS: usize = 20;

/// For each dimension after the first: degree and inner coefficients of its primitive polynomial, and the first odd m_i.
const JOE_KUO: [(u32, u32, &[u32]); DIMENSIONS - 1] = [
    (1, 0, &[1]),
    (2, 1, &[1, 3]),
    (3, 1, &[1, 3, 1]),
    (3, 2, &[1, 1, 1]),
    (4, 1, &[1, 1, 3, 3]),
    (4, 4, &[1, 3, 5, 13]),
    (5, 2, &[1, 1, 5, 5, 17]),
    (5, 4, &[1, 1, 5, 5, 5]),
    (5, 7, &[1, 1, 7, 11, 19]),
    (5, 11, &[1, 1, 5, 1, 1]),
    (5, 13, &[1, 1, 1, 3, 11]),
    (5, 14, &[1, 3, 5, 5, 31]),
    (6, 1, &[1, 3, 3, 9, 7, 49]),
    (6, 13, &[1, 1, 1, 15, 21, 21]),
    (6, 16, &[1, 3, 1, 13, 27, 49]),
    (6, 19, &[1, 1, 1, 15, 7, 5]),
    (6, 22, &[1, 3, 1, 15, 13, 25]),
    (6, 25, &[1, 1, 5, 5, 19, 61]),
    (7, 1, &[1, 3, 7, 11, 23, 15, 103]),
];

/// Column k of a dimension is what bit k of the index adds; bit i of it is the digit of weight 2^−(i+1).
pub const COLUMNS: [[u32; 32]; DIMENSIONS] = columns();

const fn columns() -> [[u32; 32]; DIMENSIONS] {
    let mut all = [[0; 32]; DIMENSIONS];
    let mut k = 0;
    while k < 32 {
        all[0][k] = 1 << k;
        k += 1;
    }
    let mut dimension = 1;
    while dimension < DIMENSIONS {
        all[dimension] = dimension_columns(JOE_KUO[dimension - 1]);
        dimension += 1;
    }
    all
}

const fn dimension_columns((degree, coefficients, first): (u32, u32, &[u32])) -> [u32; 32] {
    let degree = degree as usize;
    let mut v = [0u32; 32];
    let mut k = 0;
    while k < 32 {
        // v is m_k at the top of the word until the end.
        if k < degree {
            v[k] = first[k] << (31 - k);
        } else {
            v[k] = v[k - degree] ^ (v[k - degree] >> degree);
            let mut i = 1;
            while i < degree {
                if coefficients >> (degree - 1 - i) & 1 != 0 {
                    v[k] ^= v[k - i];
                }
                i += 1;
            }
        }
        k += 1;
    }
    let mut k = 0;
    while k < 32 {
        v[k] = v[k].reverse_bits();
        k += 1;
    }
    v
}
