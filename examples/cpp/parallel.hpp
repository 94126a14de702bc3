// The host's threads: covbeam starts none.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

// Calls body(index, thread) for all indices below count. The first exception ends all threads and is thrown here.
template <class Body> void parallel(unsigned threads, int count, const Body& body) {
    std::atomic<int> next{0};
    std::exception_ptr thrown;
    std::mutex mutex;
    std::vector<std::thread> workers;
    for (unsigned thread = 0; thread < threads; ++thread) {
        workers.emplace_back([&, thread] {
            try {
                for (int index; (index = next++) < count;) body(index, thread);
            } catch (...) {
                std::lock_guard<std::mutex> lock(mutex);
                if (!thrown) thrown = std::current_exception();
                next = count;
            }
        });
    }
    for (std::thread& worker : workers) worker.join();
    if (thrown) std::rethrow_exception(thrown);
}
