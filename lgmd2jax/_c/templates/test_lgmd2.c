/* Whether lgmd2.c computes what model.json says: its test clip, and the response to it. */
#include "lgmd2.h"

#include <math.h>
#include <stdio.h>

#include "test_vector.h"

static lgmd2_state state;

/* Prints a value that is off by more than is allowed, NaN too. */
static int differs(int frame, const char *name, float value, float wanted, float by)
{
    if (fabsf(value - wanted) <= by)
        return 0;
    printf("test vector: %s of frame %d is %.9g, not %.9g\n", name, frame, (double)value, (double)wanted);
    return 1;
}

int main(void)
{
    int wrong = 0;

    lgmd2_init(&state);
    for (int t = 0; t < FRAMES && wrong == 0; t++) {
        lgmd2_output now;
        const lgmd2_output *want = &expected[t];

        lgmd2_step(&state, frames[t], interval_ms, &now);
        wrong += differs(t, "mp", now.mp, want->mp, allowed.mp);
        wrong += differs(t, "ffi", now.ffi, want->ffi, allowed.ffi);
        wrong += differs(t, "smp", now.smp, want->smp, allowed.smp);
        wrong += differs(t, "smp_adapted", now.smp_adapted, want->smp_adapted, allowed.smp_adapted);
        wrong += differs(t, "spikes", (float)now.spikes, (float)want->spikes, 0.0f);
        wrong += differs(t, "collision", (float)now.collision, (float)want->collision, 0.0f);
    }
    if (wrong == 0)
        printf("test vector: %d frames of %d x %d came out\n", (int)FRAMES, LGMD2_ROWS, LGMD2_COLS);
    return wrong != 0;
}
