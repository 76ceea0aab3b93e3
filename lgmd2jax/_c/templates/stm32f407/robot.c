/* An example of a robot's loop; its camera and its motors are yours to write. */
#include "lgmd2.h"

static lgmd2_state state;
static uint8_t grey[LGMD2_ROWS * LGMD2_COLS];

/* Fills the frame; returns ms since the last one. Here something that moves, so that the program runs by itself. */
static float camera_read(uint8_t *pixels)
{
    static unsigned shift;

    shift++;
    for (unsigned i = 0; i < sizeof grey; i++)
        pixels[i] = (uint8_t)((i + shift) * 29U);
    return 33.3f;
}

static void turn(void)
{
}

int main(void)
{
    lgmd2_init(&state);
    for (;;) {
        lgmd2_output now;

        lgmd2_step(&state, grey, camera_read(grey), &now);
        if (now.collision)
            turn();
    }
}
