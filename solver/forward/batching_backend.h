// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "physics/simulation/backend.h"

namespace drape {

// The backend of one of several concurrent tasks: its calls wait for those of the other tasks and
// are answered together with them.
class BatchingBackend : public Backend {
 public:
  virtual int index() const = 0;
  // Calls `act` on the thread of RunBatched while all tasks wait, so that `act` needs no lock.
  virtual void RunSerially(const std::function<void()>& act) = 0;
};

// Runs work(task) for the tasks 0..count − 1, each on a thread of its own, at most max_threads at a
// time. A call is answered, by the calling thread, only when every task that has begun waits in a
// call or has ended:
// - first a RunSerially, that of the lowest task;
// - otherwise the largest group of calls of one kind with equal options (of equal groups, that of
// the
//   lowest task), as one batch of `inner`, in the order of the tasks. Calls with recordings and
//   adjoints are not joined.
// So which calls are joined and the order of all answers depend on the tasks alone, never on the
// timing of threads, and `inner` needs no synchronisation of its own.
// An exception of `inner` or of a RunSerially is rethrown in each task whose call it was to answer.
// One that leaves a task ends the others, whose next calls throw it too, and is thrown here when
// all have ended; of several, that of the lowest task.
void RunBatched(Backend& inner, int count, int max_threads,
                const std::function<void(BatchingBackend&)>& work);

// Backends that threads share which come and go: calls of one backend are answered together, as by
// RunBatched, but already when half of the members wait in one. Which calls are joined depends on
// the timing of threads, and no bit of an answer does. Where an answer throws, its calls do.
class SharedBackends {
 public:
  SharedBackends();
  SharedBackends(const SharedBackends&) = delete;
  SharedBackends& operator=(const SharedBackends&) = delete;
  ~SharedBackends();  // after that of all members

  // What one thread uses, and threads that it waits for, one at a time.
  class Member {
   public:
    explicit Member(SharedBackends& all);
    Member(const Member&) = delete;
    Member& operator=(const Member&) = delete;
    ~Member();
    // A backend that passes calls on to the one of this key, which the first call for the key
    // makes. The member outlives it.
    std::unique_ptr<Backend> Share(const std::string& key,
                                   const std::function<std::unique_ptr<Backend>()>& make);

   private:
    SharedBackends& all_;
    int index_;
  };

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace drape
