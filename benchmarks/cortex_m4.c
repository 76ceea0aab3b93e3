/* Frames of texture in motion with the noise of a camera, for benchmarks/cortex_m4.py, which counts instructions. */
#include "lgmd2.h"

static lgmd2_state state;
static uint8_t grey[LGMD2_ROWS * LGMD2_COLS];

static void picture(unsigned t)
{
    static unsigned random = 1;

    for (unsigned r = 0; r < LGMD2_ROWS; r++)
        for (unsigned c = 0; c < LGMD2_COLS; c++) {
            const bool inside = r > 30 - t && r < 40 + t && c > 40 - t && c < 60 + t;
            random = random * 1664525U + 1013904223U;
            grey[r * LGMD2_COLS + c] = (uint8_t)((inside ? 20U : 150U + ((r * 7U + c * 13U) & 63U)) + (random >> 28));
        }
}

int main(void)
{
    lgmd2_output now = {0};

    lgmd2_init(&state);
    for (unsigned t = 0; t < 3; t++) {
        picture(5 * t);
        lgmd2_step(&state, grey, 33.3f, &now);
    }
    return now.spikes < 0;
}
