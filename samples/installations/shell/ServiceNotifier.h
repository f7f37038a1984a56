#pragma once

#include <string>

namespace midair::samples
{

/// Notifies systemd that the service is ready and that its frames continue (sd_notify(3): datagrams
/// to $NOTIFY_SOCKET). Does nothing if the program is not a service.
class ServiceNotifier
{
public:
    ServiceNotifier();
    ~ServiceNotifier();
    ServiceNotifier(const ServiceNotifier&) = delete;
    ServiceNotifier& operator=(const ServiceNotifier&) = delete;

    /// Call it in each frame with a steady clock's \a now_s. The first call sends READY; a watchdog
    /// signal is sent three times per $WATCHDOG_USEC. \a status is a line for `systemctl status`.
    void beat(double now_s, const std::string& status);
    /// Notifies that the program is about to end.
    void stop();

private:
    void send(const std::string& text) const;

    int _socket = -1;
    double _interval_s = 1.0;
    double _last_s = -1e9;
    bool _isReady = false;
    std::string _address;
};

} // namespace midair::samples
