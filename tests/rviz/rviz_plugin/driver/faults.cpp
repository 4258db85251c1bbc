// Faults that a test provokes in rviz's process, which loads this library before all others (LD_PRELOAD). Environment variables:
//
//   RVIZ_FAULTS_LARGEST_BYTES=N   `new` has no memory for more than N bytes
//   RVIZ_FAULTS_NO_THREADS=FILE   no thread can be started while FILE exists
//   RVIZ_FAULTS_FENCES=FILE       the driver fails with fences; FILE gets a line for each try
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include <dlfcn.h>
#include <pthread.h>
#include <unistd.h>

namespace
{
template <typename Function>
Function next(const char* name)
{
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

using FenceSync = void* (*)(unsigned, unsigned);
FenceSync real_fence_sync;

/// Makes the driver report an error: there is no condition 0.
void* failingFenceSync(unsigned, unsigned flags)
{
  if (FILE* file = std::fopen(std::getenv("RVIZ_FAULTS_FENCES"), "a"))
  {
    std::fputs("a fence\n", file);
    std::fclose(file);
  }
  return real_fence_sync(0, flags);
}
}  // namespace

void* operator new(std::size_t size)
{
  static const char* const largest = std::getenv("RVIZ_FAULTS_LARGEST_BYTES");
  if (largest && size > std::strtoull(largest, nullptr, 10))
    throw std::bad_alloc();
  void* const memory = std::malloc(size ? size : 1);
  if (!memory)
    throw std::bad_alloc();
  return memory;
}

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument)
{
  static const auto real = next<decltype(&pthread_create)>("pthread_create");
  const char* const file = std::getenv("RVIZ_FAULTS_NO_THREADS");
  return file && access(file, F_OK) == 0 ? EAGAIN : real(thread, attributes, start, argument);
}

extern "C" void (*glXGetProcAddressARB(const unsigned char* name))()
{
  using Look = void (*(*)(const unsigned char*))();
  static const auto real = next<Look>("glXGetProcAddressARB");
  void (*const found)() = real(name);
  if (!std::getenv("RVIZ_FAULTS_FENCES") || std::strcmp(reinterpret_cast<const char*>(name), "glFenceSync") != 0)
    return found;
  real_fence_sync = reinterpret_cast<FenceSync>(found);
  return reinterpret_cast<void (*)()>(&failingFenceSync);
}
