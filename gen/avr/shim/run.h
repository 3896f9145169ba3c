/* Running until something stops it. */
#ifndef GEN_RUN_H
#define GEN_RUN_H

#include "core.h"

/* Run until the cycle counter reaches limit or a part stops the run: an enum gen_stop. */
int mega_run(struct gen_mega *mega, uint64_t limit);

/* The same, instruction by instruction, until the program counter (in bytes) stands at a place. */
int mega_run_to(struct gen_mega *mega, uint64_t limit, uint32_t place);

#endif
