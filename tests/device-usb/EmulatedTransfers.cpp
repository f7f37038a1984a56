#include "tests/device-usb/Descriptors.h"
#include "tests/device-usb/EmulatedArray.h"
#include "tests/device-usb/Testbed.h"

#include <algorithm>
#include <cerrno>
#include <random>
#include <utility>

// The emulated array's end of the wire: what becomes of a transfer.

namespace
{

constexpr int kFieldBytes =
    40; // longer transfers carry a field, shorter ones a greeting, a keep-alive or a commit
constexpr std::uint8_t kCommit = 0x03;

} // namespace

void EmulatedArray::startOut(const Urb& urb)
{
    if (!_hanging.empty()) // an endpoint carries transfers in their order
    {
        _hanging.push_back(urb);
        return;
    }
    const int length = urb.fields().buffer_length;
    const bool field = length > kFieldBytes;
    const bool commit = length < kFieldBytes && urb.buffer->data[3] == kCommit;
    std::atomic<int>& stalling = commit ? stalledCommits : stalls;
    if ((field || commit) && stalling > 0)
    {
        --stalling;
        _outHalted = true;
    }
    if (_outHalted) return finish(urb, -EPIPE, 0);
    if (field && hangs > 0)
    {
        --hangs;
        _hanging.push_back(urb);
        return;
    }
    int taken = length;
    if (field && shorts > 0)
    {
        --shorts;
        taken = length / 2;
    }
    if (commit && onCommit) onCommit(urb.buffer->data);
    _take(urb.buffer->data, static_cast<std::size_t>(taken));
    if (field && taken == length)
    {
        ++fieldTransfers;
        if (onField) onField(urb.buffer->data);
    }
    finish(urb, 0, taken);
}

void EmulatedArray::letGo()
{
    std::lock_guard<std::mutex> lock(_mutex);
    startHanging();
    _node.set(isDue());
}

void EmulatedArray::startHanging()
{
    for (const Urb& urb : std::exchange(_hanging, {}))
        startOut(urb);
}

void EmulatedArray::answerControl(const Urb& urb)
{
    const guint8* setup = urb.buffer->data;
    const int asked = setup[6] + 256 * setup[7];
    if (setup[0] == 0x80 && setup[1] == 6 && setup[3] == 3)
    {
        std::vector<std::uint8_t> answer = {4, 3, 9, 4}; // languages: English
        if (setup[2] != 0) answer = stringDescriptor(setup[2] == 3 ? serialOf(_port) : "osgMidair");
        const int count = std::min<int>(asked, static_cast<int>(answer.size()));
        umockdev_ioctl_data_update(urb.buffer, 8, answer.data(), count);
        return finish(urb, 0, count);
    }
    if (setup[0] == 0x41 && setup[1] == 0x4D && setup[4] == 1)
    {
        _firmware.receive(setup + 8, static_cast<std::size_t>(asked), now_s());
        if (onControl) onControl(setup + 8);
        return finish(urb, 0, asked);
    }
    if (_isFifo && setup[0] == 0x40) return finish(urb, 0, asked); // FTDI's settings
    finish(urb, -EPIPE, 0);
}

void EmulatedArray::feedIn()
{
    while (!_waitingIn.empty() && !mute && _firmware.hasAnswer(now_s()))
    {
        const Urb urb = _waitingIn.front();
        std::vector<std::uint8_t> bytes =
            _firmware.takeAnswer(static_cast<std::size_t>(urb.fields().buffer_length), now_s());
        if (nonsense)
        {
            static std::minstd_rand random(1);
            for (std::uint8_t& byte : bytes)
                byte = static_cast<std::uint8_t>(random() >> 8);
        }
        _waitingIn.pop_front();
        umockdev_ioctl_data_update(urb.buffer, 0, bytes.data(), static_cast<gint>(bytes.size()));
        finish(urb, 0, static_cast<int>(bytes.size()));
    }
}

void EmulatedArray::finish(const Urb& urb, int status, int length)
{
    usbdevfs_urb done = urb.fields();
    done.status = status;
    done.actual_length = length;
    umockdev_ioctl_data_update(urb.data,
                               offsetof(usbdevfs_urb, status),
                               reinterpret_cast<guint8*>(&done.status),
                               sizeof done.status);
    umockdev_ioctl_data_update(urb.data,
                               offsetof(usbdevfs_urb, actual_length),
                               reinterpret_cast<guint8*>(&done.actual_length),
                               sizeof done.actual_length);
    _done.push_back(urb);
}

void EmulatedArray::endAll(int error)
{
    for (auto* queue : {&_waitingIn, &_hanging})
    {
        for (const Urb& urb : *queue)
            finish(urb, error, 0);
        queue->clear();
    }
}
