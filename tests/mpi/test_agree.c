/* Run by mpirun: agreements between ranks (lib/comm) that are started and finished later: sums, maxima and
 * failures arrive at all ranks, and messages that are sent in between are not confused with them. Results are
 * known from the numbers of ranks. */
#include <math.h>
#include <string.h>
#include "lib/comm/ranks.h"
#include "tests/check.h"

static struct kith_ranks *ranks;

static int right(void) {
  return (kith_ranks_rank(ranks) + 1) % kith_ranks_size(ranks);
}
static int left(void) {
  const int size = kith_ranks_size(ranks);
  return (kith_ranks_rank(ranks) + size - 1) % size;
}

/* Sends the number of this rank to the right; returns the number that arrives from the left. */
static int64_t send_right(void) {
  int64_t mine = kith_ranks_rank(ranks), from = -1;
  const struct kith_message out = {right(), &mine, sizeof mine}, in = {left(), &from, sizeof from};
  CHECK_OK(kith_ranks_exchange(ranks, 1, &out, 1, &in));
  return from;
}

static void test_sum_and_max(void) {
  const int64_t size = kith_ranks_size(ranks);
  int64_t count = 1 + kith_ranks_rank(ranks);
  double most = (double)count;
  const struct kith_shared parts[] = {{KITH_SHARE_SUM, 1, &count}, {KITH_SHARE_MAX, 1, &most}};
  CHECK_OK(kith_ranks_finish_agree(ranks)); /* none was started */
  CHECK_OK(kith_ranks_start_agree(ranks, KITH_OK, 2, parts));
  CHECK(count == 1 + kith_ranks_rank(ranks));
  CHECK_OK(kith_ranks_finish_agree(ranks));
  CHECK(count == size * (size + 1) / 2);
  CHECK(most == (double)size);
}

/* Of numbers of which one is NaN all ranks have the same maximum: what they decide by it must not differ. */
static void test_max_of_nan(void) {
  for (int who = 0; who < kith_ranks_size(ranks); ++who) {
    double most[2] = {kith_ranks_rank(ranks) == who ? NAN : 1, 7};
    CHECK_OK(kith_ranks_agree(ranks, KITH_OK, 1, &(struct kith_shared){KITH_SHARE_MAX, 2, most}));
    CHECK(isnan(most[0]) && most[1] == 7);
  }
}

/* A message, another agreement, or a maximum finishes the agreement that was started before. */
static void test_finished_by_others(void) {
  const int64_t size = kith_ranks_size(ranks);
  for (int how = 0; how < 3; ++how) {
    int64_t first = 1, second = 2;
    double most = kith_ranks_rank(ranks);
    CHECK_OK(kith_ranks_start_agree(ranks, KITH_OK, 1, &(struct kith_shared){KITH_SHARE_SUM, 1, &first}));
    if (how == 0 && size > 1) CHECK(send_right() == left());
    if (how == 1)
      CHECK_OK(kith_ranks_agree(ranks, KITH_OK, 1, &(struct kith_shared){KITH_SHARE_SUM, 1, &second}));
    if (how == 2) kith_ranks_max(ranks, &most, 1);
    CHECK(size == 1 || how != 0 || first == size);
    CHECK(how != 1 || (first == size && second == 2 * size));
    CHECK(how != 2 || most == (double)(size - 1));
    CHECK_OK(kith_ranks_finish_agree(ranks));
    CHECK(first == size);
  }
}

/* The last rank fails, and skips the messages and sums that the others make before they know of it. */
static void test_failure(int how) {
  const int size = kith_ranks_size(ranks);
  const bool fails = kith_ranks_rank(ranks) == size - 1;
  int64_t to[8] = {0}, from[8];
  const int32_t neighbor[] = {right()};
  if (size == 1 || size > 8) return;
  kith_status status = fails ? kith_fail(KITH_OUTGROWN, "too wide") : KITH_OK;
  status = kith_ranks_start_agree(ranks, status, 0, NULL);
  if (!fails) {
    double most = 5;
    CHECK_OK(status);
    CHECK(send_right() == -1);
    kith_ranks_max(ranks, &most, 1);
    CHECK(most == 5);
    for (int k = 0; k < 8; ++k) from[k] = -1;
    kith_ranks_tell(ranks, 1, neighbor, to, from, 1);
    CHECK(from[neighbor[0]] == 0);
    status = how == 0   ? kith_ranks_finish_agree(ranks)
             : how == 1 ? kith_ranks_agree(ranks, KITH_OK, 0, NULL)
                        : kith_ranks_start_agree(ranks, KITH_OK, 0, NULL);
  }
  CHECK_STATUS(KITH_OUTGROWN, status);
  char wanted[64];
  snprintf(wanted, sizeof wanted, "rank %d: too wide", size - 1);
  CHECK(strstr(kith_failure(), wanted) != NULL);
  CHECK(kith_ranks_status_is_shared(ranks));
  CHECK_OK(kith_ranks_finish_agree(ranks)); /* the failure is reported only once */
  CHECK(send_right() == left());
}

int main(void) {
  CHECK_OK(kith_ranks_create(&ranks));
  test_sum_and_max();
  test_max_of_nan();
  test_finished_by_others();
  for (int how = 0; how < 3; ++how) test_failure(how);
  test_sum_and_max();
  const int failed = kith_ranks_any(ranks, check_failed() != 0);
  kith_ranks_destroy(&ranks);
  return failed;
}
