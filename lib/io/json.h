/* json.h - the two things about JSON that go wrong: strings and numbers. Everything else is fprintf. */
#ifndef KITH_IO_JSON_H
#define KITH_IO_JSON_H

#include <stdio.h>
#include "lib/core/base.h"

/* In quotes, escaped; NULL becomes null. Bytes that are not UTF-8 become '?', since JSON is UTF-8. */
void kith_json_string(FILE *out, const char *text);
/* All 17 digits, so that reading gives the same double; what is not finite becomes null. */
void kith_json_number(FILE *out, double value);

#endif
