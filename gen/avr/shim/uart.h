/* UART0's outer side. */
#ifndef GEN_UART_H
#define GEN_UART_H

#include "core.h"

extern const struct part mega_uart_part;

/* Let a run stop once length bytes of pattern have been sent; 0: none. -1, with a message: it is too long. */
int mega_uart_await(struct gen_mega *mega, const uint8_t *pattern, size_t length);

size_t gen_mega_uart_available(const struct gen_mega *mega);
size_t gen_mega_uart_take(struct gen_mega *mega, uint8_t *to, size_t capacity);

/* Forget what UART0 sent so far as far as patterns go: a pattern must lie wholly in later bytes. */
void gen_mega_uart_forget(struct gen_mega *mega);

/* Queue bytes for the receiver, one every byte_cycles from now on. 0 when it worked. */
int gen_mega_uart_send(struct gen_mega *mega, const uint8_t *bytes, size_t count, uint32_t byte_cycles);

#endif
