// A mutex, where there are threads: a page has one, and no std::mutex.
#pragma once

#ifndef __wasi__
#include <mutex>
#endif

namespace thimble::host {

#ifdef __wasi__
struct Mutex {};
struct MutexLock {
  explicit MutexLock(Mutex& /*mutex*/) {}
};
#else
using Mutex = std::mutex;
using MutexLock = std::scoped_lock<std::mutex>;
#endif

}  // namespace thimble::host
