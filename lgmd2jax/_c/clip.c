/* A whole clip, from rest: for the host, which calls once and not once a frame. */
#include "lgmd2.h"

void lgmd2_clip(const uint8_t *frames, const float *interval_ms, int count, lgmd2_output *outputs);

void lgmd2_clip(const uint8_t *frames, const float *interval_ms, int count, lgmd2_output *outputs)
{
    static lgmd2_state state;

    lgmd2_init(&state);
    for (int t = 0; t < count; t++)
        lgmd2_step(&state, &frames[t * LGMD2_ROWS * LGMD2_COLS], interval_ms[t], &outputs[t]);
}
