#include "core.h"

#include <stdarg.h>
#include <stdio.h>

void mega_stop(struct gen_mega *mega, int reason)
{
	if (mega->stopped)
		return;
	mega->stopped = 1;
	mega->stop = reason;
	if (mega->avr->state == cpu_Running || mega->avr->state == cpu_Sleeping) {
		mega->resume = mega->avr->state;
		mega->avr->state = cpu_Stopped; /* leaves avr_run_one's inner loop after this instruction */
	}
}

void mega_note(struct gen_mega *mega, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(mega->message, sizeof mega->message, format, arguments);
	va_end(arguments);
}
