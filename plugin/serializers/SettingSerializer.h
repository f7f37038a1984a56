#pragma once

#include "plugin/settings/AllSettings.h"

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <string>
#include <type_traits>
#include <utility>

namespace osgMidair
{

/// Serializer of one setting of a struct \a T, which nodes of class \a C get and set as a whole. It
/// stores it as OSG's own serializers store a property: in text files where it differs from the
/// default, in .osgb always, found by its position. Binary files of versions before the setting's
/// don't have it.
template<class C, class T>
class SettingSerializer : public osgDB::BaseSerializer
{
public:
    // Functions and not members, since a member of a base that is called through the node's class
    // is a false alarm to g++'s undefined-behaviour sanitizer.
    using Get = const T& (*)(const C&);
    using Set = void (*)(C&, const T&);

    SettingSerializer(Setting<T> setting, Get get, Set set) :
        osgDB::BaseSerializer(READ_WRITE_PROPERTY),
        _setting(std::move(setting)),
        _name(_setting.storedName()),
        _get(get),
        _set(set)
    {
        for (const Word& word : _setting.words)
            _words.add(word.stored.c_str(), word.value);
    }

    const std::string& getName() const override { return _name; }

    osgDB::IntLookup* getIntLookup() override { return _setting.words.empty() ? nullptr : &_words; }

    /// Returns OSG's type for the kind of setting.
    Type type() const
    {
        constexpr Type kTypes[] = {RW_BOOL, RW_INT, RW_DOUBLE, RW_ENUM, RW_STRING, RW_MATRIXD};
        static_assert(std::size(kTypes) >= std::variant_size_v<Member<T>>);
        return kTypes[_setting.member.index()];
    }

    bool read(osgDB::InputStream& in, osg::Object& object) override
    {
        auto& node = static_cast<C&>(object);
        if (in.isBinary() ? node.getReadVersion() < _setting.since : !in.matchString(_name))
            return true;
        T all = _get(node);
        if (std::visit([&](auto member) { return readInto(in, all, member); }, _setting.member))
            _set(node, all);
        return true;
    }

    bool write(osgDB::OutputStream& out, const osg::Object& object) override
    {
        const T& all = _get(static_cast<const C&>(object));
        if (!out.isBinary())
        {
            if (isStoredAlike(all)) return true;
            out << out.PROPERTY(_name.c_str());
        }
        std::visit([&](auto member) { writeFrom(out, all, member); }, _setting.member);
        if (!out.isBinary()) out << std::endl;
        return true;
    }

private:
    /// Returns false for an empty text in a text file, which leaves the setting unchanged.
    template<typename M>
    bool readInto(osgDB::InputStream& in, T& all, M member)
    {
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            int value = 0;
            std::string word;
            if (in.isBinary())
                in >> value;
            else
            {
                in >> word;
                value = _words.getValue(word.c_str());
            }
            member.set(all, value);
        }
        else if constexpr (std::is_same_v<M, std::string T::*>)
        {
            std::string text;
            if (in.isBinary())
                in >> text;
            else
                in.readWrappedString(text);
            if (text.empty() && !in.isBinary()) return false;
            all.*member = text;
            noteWish(all, text);
        }
        else
        {
            std::decay_t<decltype(all.*member)> value{};
            in >> value;
            all.*member = value;
        }
        return true;
    }

    void noteWish(T& all, const std::string& text) const
    {
        if constexpr (std::is_same_v<T, HapticSettings>)
            if (const auto wish = wishOf(_setting.name)) all.wishes.*wish = text;
    }

    template<typename M>
    void writeFrom(osgDB::OutputStream& out, const T& all, M member)
    {
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            if (out.isBinary())
                out << member.get(all);
            else
                out << _words.getString(member.get(all));
        }
        else if constexpr (std::is_same_v<M, std::string T::*>)
        {
            if (out.isBinary())
                out << all.*member;
            else
                out.writeWrappedString(all.*member);
        }
        else
            out << all.*member;
    }

    /// Returns true if the value is the default, which text files leave out. NaN is written, as it
    /// differs from everything.
    bool isStoredAlike(const T& all) const
    {
        const auto compare = [&](auto member)
        {
            if constexpr (std::is_same_v<decltype(member), Choice<T>>)
                return member.get(all) == member.get(_defaults);
            else
                return !(all.*member != _defaults.*member);
        };
        return std::visit(compare, _setting.member);
    }

    const Setting<T> _setting;
    const std::string _name;
    const Get _get;
    const Set _set;
    const T _defaults{};
    osgDB::IntLookup _words;
};

/// Adds serializers for all settings of \a table, version by version, so that newer settings follow
/// those that older files have.
template<class C, class T>
void addSettings(osgDB::ObjectWrapper& wrapper,
                 const SettingTable<T>& table,
                 typename SettingSerializer<C, T>::Get get,
                 typename SettingSerializer<C, T>::Set set)
{
    for (int version = 1; version <= table.newestVersion(); ++version)
        for (const Setting<T>& row : table.rows())
        {
            if (row.since != version) continue;
            auto* serializer = new SettingSerializer<C, T>(row, get, set);
            wrapper.addSerializer(serializer, serializer->type());
        }
}

} // namespace osgMidair
