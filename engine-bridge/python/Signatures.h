#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include <pybind11/pybind11.h>

namespace midair::python
{

namespace py = pybind11;

/// Text for Python's inspect.signature() and help() of a C function: "name(self, places, index=0)",
/// the end marker that they expect, and the docstring.
class Signature
{
public:
    Signature(const char* name, const char* self) :
        _text(std::string(name) + "("),
        _isFirst(*self == '\0')
    {
        _text += self;
    }

    template<typename... Extra>
    const char* of(const Extra&... extra)
    {
        (take(extra), ...);
        _text += std::string(")\n--\n\n") + _doc;
        return _text.c_str();
    }

private:
    template<typename Extra>
    void take(const Extra& extra)
    {
        if constexpr (std::is_base_of_v<py::arg, Extra>)
        {
            _text += std::string(_isFirst ? "" : ", ") + extra.name;
            _isFirst = false;
            if constexpr (std::is_base_of_v<py::arg_v, Extra>)
                _text += "=" + py::repr(extra.value).template cast<std::string>();
        }
        else if constexpr (std::is_convertible_v<const Extra&, const char*>)
            _doc = extra;
    }

    std::string _text;
    bool _isFirst;
    const char* _doc = "";
};

/// A class of the module whose functions have signatures.
template<typename... Options>
class Class : public py::class_<Options...>
{
    using Base = py::class_<Options...>;

public:
    using Base::Base;

    template<typename... Arguments, typename... Extra>
    Class& def(py::detail::initimpl::factory<Arguments...>&& init, const Extra&... extra)
    {
        Base::def(std::move(init), extra..., Signature("__init__", "self").of(extra...));
        return *this;
    }
    template<typename... Arguments>
    Class& def(py::detail::initimpl::pickle_factory<Arguments...>&& pickle)
    {
        Base::def(std::move(pickle));
        return *this;
    }
    template<typename Function, typename... Extra>
    Class& def(const char* name, Function&& function, const Extra&... extra)
    {
        Base::def(
            name, std::forward<Function>(function), extra..., Signature(name, "self").of(extra...));
        return *this;
    }
    template<typename Function, typename... Extra>
    Class& def_static(const char* name, Function&& function, const Extra&... extra)
    {
        Base::def_static(
            name, std::forward<Function>(function), extra..., Signature(name, "").of(extra...));
        return *this;
    }
    template<typename Getter, typename... Extra>
    Class& def_property_readonly(const char* name, const Getter& getter, const Extra&... extra)
    {
        Base::def_property_readonly(name, getter, extra...);
        return *this;
    }
    template<typename Member, typename... Extra>
    Class& def_readonly(const char* name, Member member, const Extra&... extra)
    {
        Base::def_readonly(name, member, extra...);
        return *this;
    }
};

/// Adds a function to the module, with its signature.
template<typename Function, typename... Extra>
void define(py::module_& module, const char* name, Function&& function, const Extra&... extra)
{
    module.def(name, std::forward<Function>(function), extra..., Signature(name, "").of(extra...));
}

} // namespace midair::python
