/* Records in and out of a harness built with ../mailbox.h. */
#ifndef GEN_MAILBOX_C_H
#define GEN_MAILBOX_C_H

#include "core.h"

extern const struct part mega_mailbox_part;

/* Serve count records through the mailbox; done tells how many were finished. */
int gen_mega_run_records(struct gen_mega *mega, const uint8_t *in, uint32_t in_address, uint32_t in_size, uint8_t *out,
			 uint32_t out_address, uint32_t out_size, uint32_t count, uint32_t *cycles, uint64_t limit,
			 uint32_t *done);

#endif
