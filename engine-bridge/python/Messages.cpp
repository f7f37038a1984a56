// midair.Message, and the message functions of Scene.
#include "engine-bridge/python/Bindings.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <pybind11/stl.h>

namespace midair::python
{

namespace
{

/// midair.Message.
struct PyMessage
{
    midair_message of{};
    std::string text;
};

const char* severityOf(const PyMessage& message)
{
    constexpr const char* kNames[] = {"notice", "warning", "fault"};
    return kNames[message.of.severity];
}

std::vector<midair_message> listed(const PyScene& scene)
{
    std::vector<midair_message> all(100);
    std::size_t count = 0;
    const midair_status status =
        unlocked(midair_list_messages, scene.get(), all.data(), all.size(), &count);
    if (status < 0) raise(status);
    all.resize(count);
    return all;
}

std::vector<PyMessage> messagesOf(const PyScene& scene)
{
    std::vector<PyMessage> messages;
    for (const midair_message& one : listed(scene))
    {
        try
        {
            messages.push_back({one, textFrom(midair_message_text, scene.get(), one.number)});
        }
        catch (const py::error_already_set&)
        {
            continue; // it was dropped meanwhile
        }
    }
    return messages;
}

std::vector<PyMessage> activeMessagesOf(const PyScene& scene)
{
    std::vector<PyMessage> messages = messagesOf(scene);
    const auto isOver = [](const PyMessage& message) { return message.of.active == 0; };
    messages.erase(std::remove_if(messages.begin(), messages.end(), isOver), messages.end());
    return messages;
}

// Called by update(), which has released the GIL.
void callBack(void* user, const midair_message* message, const char* text)
{
    const py::gil_scoped_acquire lock;
    try
    {
        (*static_cast<py::object*>(user))(PyMessage{*message, text});
    }
    catch (py::error_already_set& raised)
    {
        raised.discard_as_unraisable("a callback of Scene.on_message()");
    }
}

void onMessage(const PyScene& scene, const py::object& callback)
{
    // The newest callback of each scene; handles are never reused.
    static auto* const kept = new std::map<midair_scene*, py::object>;
    if (callback.is_none())
        checked(midair_on_message, scene.get(), midair_message_callback(nullptr), (void*)nullptr);
    py::object& own = (*kept)[scene.get()];
    own = callback;
    if (!callback.is_none())
        checked(midair_on_message, scene.get(), &callBack, static_cast<void*>(&own));
}

void addMessage(py::module_& module)
{
    Class<PyMessage>(module,
                     "Message",
                     "A message about a scene. It is active from its report until its condition "
                     "ends; messages about past events are never active.")
        .def_property_readonly(
            "code",
            [](const PyMessage& m) { return m.of.code; },
            "What it is about, for programs: 'device.lost'; samples/guides/MESSAGES.md has all.")
        .def_property_readonly("severity",
                               &severityOf,
                               "'notice', 'warning' or 'fault': with a fault nothing is played.")
        .def_readonly("text", &PyMessage::text, "A sentence for people, the newest.")
        .def_property_readonly(
            "object",
            [](const PyMessage& m) { return m.of.object; },
            "Object.number of the one that it is about; 0: none.")
        .def_property_readonly(
            "active",
            [](const PyMessage& m) { return m.of.active != 0; },
            "True: what it says still holds.")
        .def_property_readonly(
            "since",
            [](const PyMessage& m) { return m.of.since_s; },
            "s, as time.monotonic(): when it began to hold, or was said last.")
        .def_property_readonly(
            "until",
            [](const PyMessage& m) -> py::object
            { return m.of.until_s > 0.0 ? py::cast(m.of.until_s) : py::none(); },
            "s, as time.monotonic(): when it ended; None while it is active.")
        .def_property_readonly(
            "count", [](const PyMessage& m) { return m.of.count; }, "How often it was said.")
        .def(
            "__str__", [](const PyMessage& m) { return m.text; }, "Returns the text.")
        .def(
            "__repr__",
            [](const PyMessage& m)
            {
                return py::str("<midair.Message {} {}{}: {}>")
                    .format(severityOf(m), m.of.code, m.of.active ? "" : " (over)", m.text);
            },
            "Returns severity, code and text.");
}

} // namespace

void addMessages(py::module_& module, SceneClass& scene)
{
    addMessage(module);
    scene
        .def("on_message",
             &onMessage,
             py::arg("callback"),
             "Sets the function that gets each Message that was reported, has begun or has ended; "
             "None: none. update() calls it before it returns, the first time with all stored "
             "messages. Its exceptions go to sys.unraisablehook.")
        .def(
            "clear_messages",
            [](const PyScene& s) { checked(midair_clear_messages, s.get()); },
            "Deletes all messages that are not active.")
        .def_property_readonly(
            "messages",
            &messagesOf,
            "All stored messages, at most 100, the oldest first: a list of Message.")
        .def_property_readonly("active_messages",
                               &activeMessagesOf,
                               "The active messages, the oldest first: a list of Message.");
}

} // namespace midair::python
