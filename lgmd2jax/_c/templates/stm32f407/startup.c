/* An example of what runs before main on a Cortex-M4F, without interrupts. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t stack_top, data_start, data_end, data_flash, bss_start, bss_end; /* of stm32f407.ld */
extern int main(void);
extern void initialise_monitor_handles(void) __attribute__((weak)); /* where a debugger prints for us */
void reset(void);

static void halt(void)
{
    for (;;) {
    }
}

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*handlers[15])(void);
} vectors = {&stack_top, {reset, halt, halt, halt, halt, halt}};

void reset(void)
{
    volatile uint32_t *const coprocessors = (volatile uint32_t *)0xE000ED88;
    const uint32_t *from = &data_flash;

    *coprocessors |= 0xFU << 20; /* the floating-point unit */
    for (uint32_t *to = &data_start; to < &data_end; to++)
        *to = *from++;
    for (uint32_t *to = &bss_start; to < &bss_end; to++)
        *to = 0;
    if (initialise_monitor_handles)
        initialise_monitor_handles();
    exit(main());
}
