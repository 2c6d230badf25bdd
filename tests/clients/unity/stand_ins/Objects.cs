using System;
using System.Collections.Generic;

namespace UnityEngine
{
    /// <summary>What all objects of Unity are.</summary>
    public class Object
    {
    }

    /// <summary>A part of an object.</summary>
    public class Component : Object
    {
        /// <summary>The object.</summary>
        public GameObject gameObject { get; internal set; }

        /// <summary>Where it is.</summary>
        public Transform transform
        {
            get { return gameObject.transform; }
        }
    }

    /// <summary>A script; the engine calls its methods by their names.</summary>
    public class MonoBehaviour : Component
    {
        /// <summary>Whether it runs.</summary>
        public bool isActiveAndEnabled { get; internal set; }
    }

    /// <summary>An object in the scene.</summary>
    public sealed class GameObject : Object
    {
        private readonly List<Component> components = new List<Component>();

        /// <summary>A new one.</summary>
        public GameObject(string name)
        {
            this.name = name;
            transform = AddComponent<Transform>();
            activeSelf = true;
        }

        /// <summary>Its name.</summary>
        public string name { get; set; }

        /// <summary>Where it is.</summary>
        public Transform transform { get; private set; }

        /// <summary>Whether it is shown.</summary>
        public bool activeSelf { get; private set; }

        /// <summary>Show or hide it.</summary>
        public void SetActive(bool value)
        {
            activeSelf = value;
        }

        /// <summary>A new part of it, which does not run yet.</summary>
        public T AddComponent<T>()
            where T : Component, new()
        {
            T component = new T { gameObject = this };
            components.Add(component);
            return component;
        }
    }

    /// <summary>Where an object is, below its parent.</summary>
    public sealed class Transform : Component
    {
        /// <summary>Not moved.</summary>
        public Transform()
        {
            localPosition = Vector3.zero;
            localRotation = Quaternion.identity;
            localScale = Vector3.one;
        }

        /// <summary>What it moves with; null for the world.</summary>
        public Transform parent { get; set; }

        /// <summary>In the parent's frame.</summary>
        public Vector3 localPosition { get; set; }

        /// <summary>In the parent's frame.</summary>
        public Quaternion localRotation { get; set; }

        /// <summary>In the parent's frame.</summary>
        public Vector3 localScale { get; set; }

        /// <summary>In the world.</summary>
        public Vector3 position
        {
            get { return parent == null ? localPosition : parent.TransformPoint(localPosition); }
        }

        /// <summary>In the world.</summary>
        public Quaternion rotation
        {
            get { return parent == null ? localRotation : parent.rotation * localRotation; }
        }

        /// <summary>From its own frame into the world.</summary>
        public Vector3 TransformPoint(Vector3 point)
        {
            Vector3 above = localRotation * Vector3.Scale(localScale, point) + localPosition;
            return parent == null ? above : parent.TransformPoint(above);
        }

        /// <summary>From the world into its own frame.</summary>
        public Vector3 InverseTransformPoint(Vector3 point)
        {
            Vector3 above = parent == null ? point : parent.InverseTransformPoint(point);
            Vector3 turned = Quaternion.Inverse(localRotation) * (above - localPosition);
            Vector3 size = localScale;
            return new Vector3(turned.x / size.x, turned.y / size.y, turned.z / size.z);
        }

        /// <summary>Both at once, in the world.</summary>
        public void SetPositionAndRotation(Vector3 position, Quaternion rotation)
        {
            localPosition = parent == null ? position : parent.InverseTransformPoint(position);
            localRotation = parent == null
                ? rotation : Quaternion.Inverse(parent.rotation) * rotation;
        }
    }
}

namespace UnityEngine.Events
{
    /// <summary>Callbacks that are bound in the inspector.</summary>
    public class UnityEvent<T>
    {
        private event Action<T> Called;

        /// <summary>One more.</summary>
        public void AddListener(Action<T> call)
        {
            Called += call;
        }

        /// <summary>Call all.</summary>
        public void Invoke(T value)
        {
            Called?.Invoke(value);
        }
    }
}
