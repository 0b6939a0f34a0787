#include "signals.hpp"

#include <unistd.h>

#include <csignal>

namespace armukf::apps {
namespace {

constexpr unsigned kAgainS = 1;

volatile std::sig_atomic_t stop_requested = 0;

extern "C" void request_stop(int signal) {
  if (stop_requested != 0) {
    std::signal(signal, SIG_DFL);
    ::raise(signal);
  }
  stop_requested = 1;
  ::alarm(kAgainS);
}

/// A signal between the test of the flag and a call that waits would go unseen; this one comes
/// later, and again.
extern "C" void interrupt_again(int /*signal*/) { ::alarm(kAgainS); }

/// Unlike std::signal, lets calls that wait end.
void set_handler(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  ::sigaction(signal, &action, nullptr);
}

}  // namespace

void stop_on_signals() {
  set_handler(SIGINT, request_stop);
  set_handler(SIGTERM, request_stop);
  set_handler(SIGALRM, interrupt_again);
}

StopFlag stop_flag() { return &stop_requested; }

bool is_stopped() { return stop_requested != 0; }

}  // namespace armukf::apps
