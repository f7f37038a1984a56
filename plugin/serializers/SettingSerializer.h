#pragma once

#include "haptics/base/text/Words.h"
#include "plugin/serializers/BlockReader.h"
#include "plugin/settings/AllSettings.h"

#include <osg/Notify>
#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace osgMidair
{

/// Serializer of one setting of a struct \a T, which nodes of class \a C get and set as a whole. It
/// stores it like OSG's own serializers: in text files if it differs from the default, in .osgb
/// always, by position.
template<class C, class T>
class SettingSerializer : public NamedSerializer
{
public:
    // Functions and not members, because calling a base's member through the node's class is a
    // false alarm of g++'s undefined-behaviour sanitizer.
    using Get = const T& (*)(const C&);
    using Set = void (*)(C&, const T&);

    SettingSerializer(Setting<T> setting, Get get, Set set) :
        NamedSerializer(setting.storedName()),
        _setting(std::move(setting)),
        _get(get),
        _set(set)
    {
        for (const Word& word : _setting.words)
            _words.add(word.stored.c_str(), word.value);
    }

    osgDB::IntLookup* getIntLookup() override { return _setting.words.empty() ? nullptr : &_words; }

    /// Returns OSG's type for the setting.
    Type type() const
    {
        constexpr Type kTypes[] = {RW_BOOL, RW_INT, RW_DOUBLE, RW_ENUM, RW_STRING, RW_MATRIXD};
        static_assert(std::size(kTypes) >= std::variant_size_v<Member<T>>);
        return kTypes[_setting.member.index()];
    }

    bool read(osgDB::InputStream& in, osg::Object& object) override
    {
        auto& node = static_cast<C&>(object);
        if (!in.isBinary() && !in.matchString(_name)) return true;
        T all = _get(node);
        if (in.isBinary())
            std::visit([&](auto member) { readBinary(in, all, member); }, _setting.member);
        else
            readPlain(in, all);
        // A report may have silenced the node in the meantime.
        keepSilence(_get(node), all);
        _set(node, all);
        return true;
    }

    std::vector<std::string> names() const override { return {_name}; }
    bool concernsSafety() const override { return _setting.isSafety; }

    bool write(osgDB::OutputStream& out, const osg::Object& object) override
    {
        const T all = stored(_get(static_cast<const C&>(object)));
        if (!out.isBinary())
        {
            if (isSame(_setting.member, all, _defaults)) return true; // text files omit it
            out << out.PROPERTY(_name.c_str());
        }
        std::visit([&](auto member) { writeFrom(out, all, member); }, _setting.member);
        if (!out.isBinary()) out << std::endl;
        return true;
    }

private:
    /// Reads from .osgb, which stores OSG's types.
    template<typename M>
    void readBinary(osgDB::InputStream& in, T& all, M member)
    {
        if constexpr (std::is_same_v<M, Choice<T>>)
        {
            int value = 0;
            in >> value;
            member.set(all, value);
        }
        else
        {
            std::decay_t<decltype(all.*member)> value{};
            in >> value;
            all.*member = value;
            noteWish(all);
        }
    }

    /// Reads the value after the name in a text file. An invalid value leaves the setting
    /// unchanged, with a message.
    void readPlain(osgDB::InputStream& in, T& all)
    {
        BlockReader& reader = BlockReader::of(in);
        if (type() == RW_STRING)
        {
            const std::string text = reader.readText();
            if (text.empty()) return;
            _setting.assign(all, text);
            noteWish(all);
            return;
        }
        std::string text;
        if (type() == RW_MATRIXD)
            for (const std::string& word : reader.readWords())
                text += word + " ";
        else if (type() == RW_DOUBLE)
            text = reader.readValue(
                [this](const std::string& words)
                {
                    T scratch;
                    return _setting.assign(scratch, words);
                });
        else
            text = reader.readValue();
        if (_setting.assign(all, text))
        {
            const std::string problem = _setting.problem(all, text);
            std::string what;
            if (_setting.repair(all, what))
                reader.complain(
                    _name + " " + problem +
                        (_setting.isSafety ? "" : "; " + _setting.defaultText() + " is used"),
                    _setting.isSafety);
            return;
        }
        std::vector<std::string> words;
        for (const Word& word : _setting.words)
            words.push_back(word.stored);
        reader.complain(
            (text.empty() ? _name + " has no value" : _name + " can't be \"" + text + "\"") +
                ", should be " + _setting.expected() + midair::base::didYouMean(text, words),
            _setting.isSafety);
    }

    void noteWish(T& all) const
    {
        if constexpr (std::is_same_v<T, HapticSettings>)
            if (_setting.isWish)
                all.wishes.asked[_setting.name] = all.*std::get<std::string T::*>(_setting.member);
    }

    static void keepSilence(const T& node, T& all)
    {
        all.whySilenced = node.whySilenced;
        if constexpr (std::is_same_v<T, HapticSettings>) all.isSilenced = node.isSilenced;
    }

    /// Returns the values to store: a node silenced because of its file is stored as disabled,
    /// because the new file would not have the reason.
    T stored(const T& all) const
    {
        T kept = all;
        if (_setting.name != "enabled" || !isSilenced(all)) return kept;
        OSG_WARN << "osgMidair: a node that its file has silenced is saved with Enabled FALSE"
                 << std::endl;
        kept.enabled = false;
        return kept;
    }
    static bool isSilenced(const T& all)
    {
        if constexpr (std::is_same_v<T, HapticSettings>)
            return all.isSilenced;
        else
            return !all.whySilenced.empty();
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

    const Setting<T> _setting;
    const Get _get;
    const Set _set;
    const T _defaults{};
    osgDB::IntLookup _words;
};

/// Adds serializers for all settings of \a table.
template<class C, class T>
void addSettings(osgDB::ObjectWrapper& wrapper,
                 const SettingTable<T>& table,
                 typename SettingSerializer<C, T>::Get get,
                 typename SettingSerializer<C, T>::Set set)
{
    for (const Setting<T>& row : table.rows())
    {
        auto* serializer = new SettingSerializer<C, T>(row, get, set);
        wrapper.addSerializer(serializer, serializer->type());
    }
}

} // namespace osgMidair
