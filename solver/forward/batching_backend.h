// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "physics/simulation/backend.h"

namespace drape {

// What one of several tasks that run side by side sees: a backend whose calls wait for the other
// tasks and are answered together with theirs.
class BatchingBackend : public Backend {
 public:
  virtual int index() const = 0;
  // Calls `act` on the thread of RunBatched while all tasks wait: what it touches needs no lock.
  virtual void InOrder(const std::function<void()>& act) = 0;
};

// Runs work(task) for the tasks 0..count − 1, each on a thread of its own, at most max_threads at a
// time. Only when every task that has begun waits in a call, or has ended, is a call answered, by
// the calling thread:
// - first an InOrder, that of the lowest task;
// - otherwise the largest group of calls of one kind with equal options, the lowest task's among
//   equals, as one batch of `inner`, task by task. Calls with recordings, losses and adjoints are
//   alone; readouts must be of one kind and have as many rows in all tasks.
// So which calls are joined and the order of all answers depend on the tasks alone, never on the
// timing of threads, and `inner` needs to know nothing of threads.
// An exception of `inner` or of an InOrder reaches each task that it was to answer. One that leaves
// a task ends the others, from whose next calls it comes too, and is thrown here when all have
// ended; of several, that of the lowest task.
void RunBatched(Backend& inner, int count, int max_threads,
                const std::function<void(BatchingBackend&)>& work);

}  // namespace drape
