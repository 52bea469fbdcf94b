#include "lib/io/json.h"

#include <math.h>

/* Length of the UTF-8 sequence at s; 0 if it is none. Overlong forms and surrogates (RFC 3629) are none. */
static int sequence(const unsigned char *s) {
  const int length = s[0] < 0x80   ? 1
                     : s[0] < 0xc2 ? 0
                     : s[0] < 0xe0 ? 2
                     : s[0] < 0xf0 ? 3
                     : s[0] < 0xf5 ? 4
                                   : 0;
  for (int k = 1; k < length; ++k)
    if ((s[k] & 0xc0) != 0x80) return 0;
  const bool bad = (s[0] == 0xe0 && s[1] < 0xa0) || (s[0] == 0xed && s[1] > 0x9f) ||
                   (s[0] == 0xf0 && s[1] < 0x90) || (s[0] == 0xf4 && s[1] > 0x8f);
  return bad ? 0 : length;
}

void kith_json_string(FILE *out, const char *text) {
  if (text == NULL) {
    fputs("null", out);
    return;
  }
  fputc('"', out);
  for (const unsigned char *s = (const unsigned char *)text; *s != 0;) {
    const int length = sequence(s);
    if (*s == '"' || *s == '\\')
      fprintf(out, "\\%c", *s);
    else if (*s < 0x20 || *s == 0x7f)
      fprintf(out, "\\u%04x", *s);
    else if (length == 0)
      fputc('?', out);
    else
      fwrite(s, 1, (size_t)length, out);
    s += length > 0 ? length : 1;
  }
  fputc('"', out);
}

void kith_json_number(FILE *out, double value) {
  if (isfinite(value))
    fprintf(out, "%.17g", value);
  else
    fputs("null", out);
}
