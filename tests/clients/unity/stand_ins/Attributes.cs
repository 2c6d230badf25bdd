using System;

namespace UnityEngine
{
    /// <summary>Shown in the inspector, and saved.</summary>
    [AttributeUsage(AttributeTargets.Field)]
    public sealed class SerializeFieldAttribute : Attribute
    {
    }

    /// <summary>A heading in the inspector.</summary>
    [AttributeUsage(AttributeTargets.Field)]
    public sealed class HeaderAttribute : Attribute
    {
        /// <summary>What it says.</summary>
        public HeaderAttribute(string header)
        {
        }
    }

    /// <summary>A hint in the inspector.</summary>
    [AttributeUsage(AttributeTargets.Field)]
    public sealed class TooltipAttribute : Attribute
    {
        /// <summary>What it says.</summary>
        public TooltipAttribute(string tooltip)
        {
        }
    }

    /// <summary>Bounds in the inspector.</summary>
    [AttributeUsage(AttributeTargets.Field)]
    public sealed class RangeAttribute : Attribute
    {
        /// <summary>From, to.</summary>
        public RangeAttribute(float min, float max)
        {
        }
    }

    /// <summary>Where the component is in the menu.</summary>
    [AttributeUsage(AttributeTargets.Class)]
    public sealed class AddComponentMenuAttribute : Attribute
    {
        /// <summary>The path in the menu.</summary>
        public AddComponentMenuAttribute(string menuName)
        {
        }
    }

    /// <summary>One of a kind for an object.</summary>
    [AttributeUsage(AttributeTargets.Class)]
    public sealed class DisallowMultipleComponentAttribute : Attribute
    {
    }

    /// <summary>Its calls come before those of larger numbers.</summary>
    [AttributeUsage(AttributeTargets.Class)]
    public sealed class DefaultExecutionOrderAttribute : Attribute
    {
        /// <summary>Its place.</summary>
        public DefaultExecutionOrderAttribute(int order)
        {
            Order = order;
        }

        /// <summary>Its place.</summary>
        public int Order { get; private set; }
    }
}
