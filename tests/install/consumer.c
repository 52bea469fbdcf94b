/* consumer.c - a program that uses the installed libraries. */
#include <stdlib.h>
#include "lib/core/base.h"
#include "lib/nodes/nodes.h"

int main(int argc, char **argv) {
  double *field = NULL;
  if (argc != 2 || atoi(argv[1]) != NDIM || kith_resize(&field, 0, NDIM, sizeof *field) != KITH_OK) return 1;
  kith_free(&field);
  return 0;
}
